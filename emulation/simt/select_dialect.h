/// Makes gpu/kernels/dialect.h take the executor's words. Included by the compiler's command line,
/// before everything else, where gpu/ is compiled for the executor.
#pragma once

#define SCOTTY_DIALECT_HEADER "emulation/simt/dialect.h"
