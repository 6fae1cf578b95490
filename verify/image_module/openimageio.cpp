/// The module: OpenImageIO behind the interface.
#include <OpenImageIO/imageio.h>

#include <utility>

#include "verify/image_module/image_module.h"

namespace scotty::verify {
namespace {

ImagePart describe(const OIIO::ImageSpec& spec) {
    ImagePart part;
    part.name = spec.get_string_attribute("oiio:subimagename");
    part.pixels = {spec.x, spec.y, spec.width, spec.height};
    part.picture = {spec.full_x, spec.full_y, spec.full_width, spec.full_height};
    part.depth = spec.depth;
    part.deep = spec.deep;
    part.channels = spec.channelnames;
    part.channels.resize(static_cast<std::size_t>(spec.nchannels));
    part.encoding = spec.format.c_str();
    part.floating_point = spec.format.is_floating_point();
    part.color_space = spec.get_string_attribute("oiio:ColorSpace");
    part.gamma = spec.get_float_attribute("oiio:Gamma");
    for (const OIIO::ParamValue& value : spec.extra_attribs) {
        const std::string name = value.name().string();
        if (!name.starts_with("scotty:")) continue;
        part.attributes[name] = value.get_string();
        // Equal for two defaults: it is an integer, or text of one.
        const int count = spec.get_int_attribute(name, 0);
        if (count == spec.get_int_attribute(name, 1)) part.counts[name] = count;
    }
    return part;
}

class Input : public ImageInput {
 public:
    explicit Input(std::unique_ptr<OIIO::ImageInput> input) : input_(std::move(input)) {}

    std::optional<ImagePart> part(int index) override {
        if (!input_->seek_subimage(index, 0)) {
            (void)input_->geterror();  // clears it: having no further part is no error
            return std::nullopt;
        }
        return describe(input_->spec());
    }

    std::string read(std::vector<float>& values) override {
        const OIIO::ImageSpec spec = input_->spec();
        values.resize(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
                      static_cast<std::size_t>(spec.nchannels));
        const bool whole = input_->read_image(input_->current_subimage(), 0, 0, spec.nchannels,
                                              OIIO::TypeDesc::FLOAT, values.data());
        return whole ? std::string() : "is damaged or cut short: " + input_->geterror();
    }

 private:
    std::unique_ptr<OIIO::ImageInput> input_;
};

class Module : public ImageModule {
 public:
    std::string version() const override {
        return std::string(OIIO::get_string_attribute("version", "version unknown")) +
               ", built against " + OIIO_VERSION_STRING;
    }

    std::unique_ptr<ImageInput> open(const std::string& path, std::string& error) const override {
        OIIO::ImageSpec wishes;
        wishes.attribute("oiio:UnassociatedAlpha", 1);  // colours not multiplied by alpha
        auto input = OIIO::ImageInput::open(path, &wishes);
        if (!input) {
            error = "cannot be read as an image: " + OIIO::geterror();
            return nullptr;
        }
        return std::make_unique<Input>(std::move(input));
    }

    std::string write(const std::string& path, const ImageToWrite& image) const override {
        const OIIO::TypeDesc type =
            image.floats != nullptr ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8;
        OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(image.channels.size()),
                             type);
        spec.channelnames = image.channels;
        for (const auto& [name, value] : image.attributes) spec.attribute(name, value);
        for (const auto& [name, value] : image.counts) spec.attribute(name, value);
        const void* data = image.floats;
        if (data == nullptr) data = image.bytes;
        const auto output = OIIO::ImageOutput::create(path);
        if (!output) return OIIO::geterror();
        const bool written =
            output->open(path, spec) && output->write_image(type, data) && output->close();
        return written ? std::string() : output->geterror();
    }
};

}  // namespace
}  // namespace scotty::verify

/// kImageModuleEntry.
extern "C" __attribute__((visibility("default"))) const scotty::verify::ImageModule*
scotty_image_module_1() {
    static const scotty::verify::Module module;
    return &module;
}
