/// The CUDA runtime's errors that a CPU can have, for both executors of CUDA text: numbers, names
/// and words are those of CUDA.
#pragma once

#include <array>

namespace scotty::emulation {

struct CudaErrorText {
    int code;
    const char* name;
    const char* text;
};
inline constexpr std::array kCudaErrors{
    CudaErrorText{0, "cudaSuccess", "no error"},
    CudaErrorText{1, "cudaErrorInvalidValue", "invalid argument"},
    CudaErrorText{2, "cudaErrorMemoryAllocation", "out of memory"},
    CudaErrorText{3, "cudaErrorInitializationError", "initialization error"},
    CudaErrorText{9, "cudaErrorInvalidConfiguration", "invalid configuration argument"},
    CudaErrorText{12, "cudaErrorInvalidPitchValue", "invalid pitch argument"},
    CudaErrorText{13, "cudaErrorInvalidSymbol", "invalid device symbol"},
    CudaErrorText{17, "cudaErrorInvalidDevicePointer", "invalid device pointer"},
    CudaErrorText{21, "cudaErrorInvalidMemcpyDirection", "invalid copy direction for memcpy"},
    CudaErrorText{98, "cudaErrorInvalidDeviceFunction", "invalid device function"},
    CudaErrorText{100, "cudaErrorNoDevice", "no CUDA-capable device is detected"},
    CudaErrorText{101, "cudaErrorInvalidDevice", "invalid device ordinal"},
    CudaErrorText{400, "cudaErrorInvalidResourceHandle", "invalid resource handle"},
    CudaErrorText{600, "cudaErrorNotReady", "device not ready"},
    CudaErrorText{700, "cudaErrorIllegalAddress", "an illegal memory access was encountered"},
    CudaErrorText{701, "cudaErrorLaunchOutOfResources", "too many resources requested for launch"},
    CudaErrorText{702, "cudaErrorLaunchTimeout", "the launch timed out and was terminated"},
    CudaErrorText{710, "cudaErrorAssert", "device-side assert triggered"},
    CudaErrorText{719, "cudaErrorLaunchFailure", "unspecified launch failure"},
    CudaErrorText{801, "cudaErrorNotSupported", "operation not supported"},
    CudaErrorText{999, "cudaErrorUnknown", "unknown error"}};

/// The last one where there is no such code.
constexpr const CudaErrorText& cuda_error(int code) {
    for (const CudaErrorText& error : kCudaErrors) {
        if (error.code == code) return error;
    }
    return kCudaErrors.back();
}

}  // namespace scotty::emulation
