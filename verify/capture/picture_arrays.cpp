#include "verify/capture/picture_arrays.h"

#include <cstddef>
#include <system_error>
#include <vector>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "verify/capture/npy.h"

namespace scotty::verify {
namespace {

namespace fs = std::filesystem;

/// Under another name first, so that no reader ever sees half a file.
template <class Write>
void write_whole(const fs::path& file, Write&& write) {
    const fs::path unfinished = file.string() + ".unfinished";
    std::error_code error;
    try {
        write(unfinished);
        fs::rename(unfinished, file);
    } catch (const fs::filesystem_error& problem) {
        fs::remove(unfinished, error);
        throw reference::Error::bad_input(file.string(),
                                          "cannot be written: " + problem.code().message());
    } catch (...) {
        fs::remove(unfinished, error);
        throw;
    }
}

void write_colors(const fs::path& file, const reference::Image& image,
                  const std::vector<reference::Vec3>& colors) {
    const std::size_t shape[] = {image.height, image.width, 3};
    write_whole(file, [&](const fs::path& unfinished) {
        write_npy(unfinished, reference::ElementType::float32, shape, colors.data(),
                  colors.size() * sizeof(reference::Vec3));
    });
}

}  // namespace

fs::path variance_file(const fs::path& image) {
    return fs::path(image).replace_extension(".variance.npy");
}

fs::path about_file(const fs::path& image) { return fs::path(image).replace_extension(".json"); }

void write_picture_arrays(const fs::path& file, const reference::Image& image,
                          const nlohmann::ordered_json& about) {
    // The old noise goes first and the new noise comes last: no reader takes one for the other's.
    std::error_code none;
    fs::remove(variance_file(file), none);
    write_colors(file, image, image.pixels);
    write_whole(about_file(file), [&](const fs::path& unfinished) {
        reference::write_file(unfinished, about.dump(2) + "\n");
    });
    if (!image.variance.empty()) write_colors(variance_file(file), image, image.variance);
}

}  // namespace scotty::verify
