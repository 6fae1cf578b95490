/// scotty check refuses what needs it (docs/cuda-support.md).
#pragma once

#error "<cufft.h> is not supported by scotty check (docs/cuda-support.md)"
