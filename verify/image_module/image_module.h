/// Image files as a library has them, and no type of that library: what lies behind it is loaded
/// only when it is needed (verify/images/image_library.h). It throws nothing of ours; errors are
/// sentences, which the caller puts a file's name to.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scotty::verify {

struct PixelWindow {
    int x = 0, y = 0, width = 0, height = 0;
    bool operator==(const PixelWindow&) const = default;
};

/// All that a part of an image file says, but for its pixels.
struct ImagePart {
    std::string name;     ///< empty: it has none
    PixelWindow pixels;   ///< which pixels are there
    PixelWindow picture;  ///< which a whole picture has
    int depth = 1;
    bool deep = false;
    std::vector<std::string> channels;
    std::string encoding;         ///< of a value: "float", "half", "uint8"
    bool floating_point = false;  ///< whether that is a floating-point type
    std::string color_space;      ///< in the library's spelling; empty: not known
    float gamma = 0.0f;           ///< 0: not known
    /// Attributes whose names begin with "scotty:", as text; `counts` has those that are integers.
    std::map<std::string, std::string> attributes;
    std::map<std::string, int> counts;
};

/// An image to be written; `floats` or `bytes` is set, row-major with all channels of a pixel
/// together.
struct ImageToWrite {
    int width = 0, height = 0;
    std::vector<std::string> channels;
    const float* floats = nullptr;
    const std::uint8_t* bytes = nullptr;
    std::map<std::string, std::string> attributes;
    std::map<std::string, int> counts;
};

/// An open file.
class ImageInput {
 public:
    virtual ~ImageInput() = default;
    /// A part by its number; nothing where there are fewer, or it is damaged.
    virtual std::optional<ImagePart> part(int index) = 0;
    /// All channels of the part that was asked for last, as floats: integers are divided by their
    /// greatest value, colours are not multiplied by alpha. Returns what went wrong, or nothing.
    virtual std::string read(std::vector<float>& values) = 0;
};

class ImageModule {
 public:
    virtual ~ImageModule() = default;
    /// The library's version, and that of the headers it was built against.
    virtual std::string version() const = 0;
    /// Returns null and says why in `error`.
    virtual std::unique_ptr<ImageInput> open(const std::string& path, std::string& error) const = 0;
    /// The format goes by the extension. Returns what went wrong, or nothing.
    virtual std::string write(const std::string& path, const ImageToWrite& image) const = 0;
};

/// The name of the module's one function, of type ImageModuleEntry. It changes with the interface,
/// so that no program takes a module of another version for its own.
inline constexpr const char* kImageModuleEntry = "scotty_image_module_1";
using ImageModuleEntry = const ImageModule* (*)();

}  // namespace scotty::verify
