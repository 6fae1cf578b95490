#include "gpu/host/traversal.cu"
