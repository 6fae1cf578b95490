#include "emulation/check/mapped_memory.h"

#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "reference/base/error.h"

namespace scotty::emulation::simt {

MappedMemory::MappedMemory(std::size_t bytes, const char* purpose) : bytes_(bytes) {
    void* mapped = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                          MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (mapped == MAP_FAILED) {
        throw reference::Error::missing_environment(
            "--check: " + std::to_string(bytes >> 30) + " GiB of address space for " + purpose +
            " refused (" + std::strerror(errno) +
            "); little of it is ever used: lift the limit (ulimit -v, vm.overcommit_memory)");
    }
    ::madvise(mapped, bytes, MADV_DONTDUMP);
    // Most pages are read before they are written, which costs two faults each, and the second one
    // interrupts all other threads. Large pages are few. Without them it works as well.
    ::madvise(mapped, bytes, MADV_HUGEPAGE);
    data_ = static_cast<std::byte*>(mapped);
}

MappedMemory::~MappedMemory() { ::munmap(data_, bytes_); }

}  // namespace scotty::emulation::simt
