#include "gpu/device_scene.cu"
