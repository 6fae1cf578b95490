#include "emulation/simt/interleave/interleaving.h"

#include <fstream>
#include <sstream>
#include <system_error>

#include "reference/base/error.h"
#include "reference/base/write_file.h"

namespace scotty::emulation::simt {

using reference::Error;

namespace {

constexpr const char* kTitle = "# scotty interleaving, version 1";

[[noreturn]] void refuse(const std::filesystem::path& file, std::size_t line,
                         const std::string& what) {
    throw Error::bad_input(file.string() + ", line " + std::to_string(line), what);
}

}  // namespace

std::string to_text(const Switch& change) {
    const std::string where =
        change.access == 0 ? "is over" : "stands before access " + std::to_string(change.access);
    return "block " + std::to_string(change.block) + " " + where + ", block " +
           std::to_string(change.to) + " goes on";
}

std::string to_text(const Interleaving& interleaving) {
    std::ostringstream out;
    out << kTitle << "\nkernel " << interleaving.kernel << "\nblocks " << interleaving.blocks
        << "\nthreads " << interleaving.threads << "\n";
    for (const Switch& change : interleaving.switches) {
        out << "switch " << change.block << " " << change.access << " " << change.to << "  # "
            << to_text(change) << "\n";
    }
    return out.str();
}

Interleaving read_interleaving(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::string line;
    if (!in || !std::getline(in, line)) throw Error::bad_input(file.string(), "cannot be read");
    if (line != kTitle)
        refuse(file, 1, "expected '" + std::string(kTitle) + "', found '" + line + "'");
    Interleaving out;
    for (std::size_t number = 2; std::getline(in, line); ++number) {
        std::istringstream words(line.substr(0, line.find('#')));
        std::string key;
        if (!(words >> key)) continue;
        bool read = false;
        if (key == "kernel") read = static_cast<bool>(words >> out.kernel);
        if (key == "blocks") read = static_cast<bool>(words >> out.blocks);
        if (key == "threads") read = static_cast<bool>(words >> out.threads);
        if (key == "switch") {
            Switch change;
            read = static_cast<bool>(words >> change.block >> change.access >> change.to);
            read = read && change.block < out.blocks && change.to < out.blocks;
            out.switches.push_back(change);
        }
        std::string more;
        if (!read || words >> more) {
            refuse(file, number,
                   "expected kernel NAME, blocks N, threads N, or switch BLOCK ACCESS TO with "
                   "blocks below their number, found '" +
                       line + "'");
        }
    }
    if (out.kernel.empty() || out.blocks == 0 || out.threads == 0) {
        throw Error::bad_input(file.string(), "names no kernel, blocks or threads");
    }
    return out;
}

void write_interleaving(const std::filesystem::path& file, const Interleaving& interleaving) {
    reference::write_file(file, to_text(interleaving));
}

}  // namespace scotty::emulation::simt
