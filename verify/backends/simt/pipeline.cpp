#include "gpu/host/pipeline.cu"
