#include "gpu/host/traversal_show.cu"
