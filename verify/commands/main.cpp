#include "verify/commands/command.h"

int main(int argc, char** argv) { return scotty::verify::run_command(argc, argv); }
