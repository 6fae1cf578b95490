#include "verify/commands/command.h"
#include "verify/mutants/plant.h"
#include "verify/mutants/planted.h"

int main(int argc, char** argv) {
    scotty::verify::offer_planted_faults(
        {scotty::planted::kRegistry, [](int number) { scotty::planted::active = number; }});
    return scotty::verify::run_command(argc, argv);
}
