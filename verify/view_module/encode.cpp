/// Pictures as bytes: JPEG while they move, PNG at rest.
#include <png.h>
#include <turbojpeg.h>

#include "verify/view_module/encode.h"

namespace scotty::verify {
namespace {

struct Compressor {
    tjhandle handle = tjInitCompress();
    Compressor() = default;
    Compressor(const Compressor&) = delete;
    Compressor& operator=(const Compressor&) = delete;
    ~Compressor() {
        if (handle != nullptr) tjDestroy(handle);
    }
};

}  // namespace

std::string encode_jpeg(const std::uint8_t* rgb, int width, int height, int quality) {
    thread_local const Compressor compressor;
    if (compressor.handle == nullptr) return {};
    std::string out(tjBufSize(width, height, TJSAMP_420), '\0');
    auto* bytes = reinterpret_cast<unsigned char*>(out.data());
    unsigned long size = out.size();
    if (tjCompress2(compressor.handle, rgb, width, 0, height, TJPF_RGB, &bytes, &size, TJSAMP_420,
                    quality, TJFLAG_NOREALLOC | TJFLAG_FASTDCT) != 0) {
        return {};
    }
    out.resize(size);
    return out;
}

std::string encode_png(const std::uint8_t* rgb, int width, int height) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(width);
    image.height = static_cast<png_uint_32>(height);
    image.format = PNG_FORMAT_RGB;
    image.flags = PNG_IMAGE_FLAG_FAST;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
    std::string out(size, '\0');
    if (png_image_write_to_memory(&image, out.data(), &size, 0, rgb, 0, nullptr) == 0) return {};
    out.resize(size);
    return out;
}

}  // namespace scotty::verify
