/// Address space that costs memory only where it is used.
#pragma once

#include <cstddef>

namespace scotty::emulation::simt {

class MappedMemory {
 public:
    /// Zeroed. Throws missing_environment, naming the purpose, if the system refuses.
    MappedMemory(std::size_t bytes, const char* purpose);
    ~MappedMemory();
    MappedMemory(const MappedMemory&) = delete;
    MappedMemory& operator=(const MappedMemory&) = delete;

    std::byte* data() const { return data_; }

 private:
    std::byte* data_;
    std::size_t bytes_;
};

}  // namespace scotty::emulation::simt
