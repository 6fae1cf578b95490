/// scotty check refuses what needs it (docs/cuda-support.md).
#pragma once

#error "<cuda_fp16.h> is not supported by scotty check (docs/cuda-support.md)"
