#include "gpu/host/replay.cu"
