#include "gpu/replay.cu"
