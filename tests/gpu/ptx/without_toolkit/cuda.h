/// GLM asks which CUDA this is.
#pragma once

#define CUDA_VERSION 12000
