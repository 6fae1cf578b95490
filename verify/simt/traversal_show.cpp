#include "gpu/traversal_show.cu"
