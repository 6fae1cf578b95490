/// Parameters of the built-in scenes: "name:key=value,key=value".
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace scotty::scenes {

/// One parameter that a scene knows. Values are numbers; `integer` ones must be whole.
struct ParameterRange {
    std::string name;
    double standard;  ///< the value where none is given
    double low;
    double high;  ///< inclusive
    bool integer = true;
};

/// The checked values of one specification.
class Parameters {
 public:
    /// `text` is what follows the colon, may be empty. Throws reference::Error (bad_input) for an
    /// unknown or repeated key, a value that is no number, or one out of range; the message names
    /// the keys and ranges that exist.
    Parameters(std::string scene, const std::string& text, std::vector<ParameterRange> known);

    double number(const std::string& name) const;
    std::uint32_t integer(const std::string& name) const;
    const std::string& scene() const { return scene_; }

 private:
    void set(const std::string& assignment);
    std::size_t index_of(const std::string& name) const;

    std::string scene_;
    std::vector<ParameterRange> known_;
    std::vector<double> values_;
    std::vector<bool> given_;
};

/// "turns=8,segments=328": the standard values, as a specification would write them.
std::string standard_text(const std::vector<ParameterRange>& known);

}  // namespace scotty::scenes
