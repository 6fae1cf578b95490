/// scotty check refuses what needs it (docs/cuda-support.md).
#pragma once

#error "<cooperative_groups/memcpy_async.h> is not supported by scotty check (docs/cuda-support.md)"
