/// Makes gpu/kernels/dialect.h use the executor's words. The compiler's command line includes it
/// before everything else where gpu/ is compiled for the executor.
#pragma once

#define SCOTTY_DIALECT_HEADER "emulation/simt/dialect.h"
