/// CUDA text includes it; everything is there already.
#pragma once

#include "scotty_cuda/cuda.h"
