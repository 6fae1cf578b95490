#include "gpu/pipeline.cu"
