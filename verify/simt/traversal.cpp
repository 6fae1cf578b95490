#include "gpu/traversal.cu"
