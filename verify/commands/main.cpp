#include "reference/base/memory.h"
#include "verify/commands/command.h"

int main(int argc, char** argv) {
    scotty::reference::keep_freed_memory();
    return scotty::verify::run_command(argc, argv);
}
