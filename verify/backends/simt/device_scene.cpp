#include "gpu/host/device_scene.cu"
