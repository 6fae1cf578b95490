/// Accessors of a glTF file: typed elements, read in batches.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "scenes/gltf_document.h"

namespace scotty::scenes {

/// Elements of 1 to 16 components each. Everything is checked when it is made: reading cannot go
/// beyond the bytes.
class GltfAccessor {
 public:
    /// accessors[index] of the file. Throws reference::Error (bad_input) naming the accessor, or
    /// `user` where there is none.
    GltfAccessor(GltfDocument& document, std::uint64_t index, const GltfObject& user);
    /// Elements that lie in memory: 32-bit floats (float_components > 0) or, where that is 0, whole
    /// numbers of 32 bits.
    GltfAccessor(std::string place, std::string bytes, unsigned float_components);

    std::uint64_t count() const { return count_; }
    unsigned components() const { return components_; }
    bool is_float() const { return component_type_ == kFloat; }
    /// Whole numbers of 8 or 16 bits.
    bool is_short() const { return component_size_ < 4; }
    /// The largest that a whole number of the components' type can be.
    std::uint32_t largest_number() const { return 0xffffffffu >> (32 - 8 * component_size_); }
    /// Whether it has a view or sparse values; else all elements are zero.
    bool has_data() const { return has_view_ || sparse_ != nullptr; }
    const std::string& place() const { return place_; }
    reference::Error error(const std::string& what) const {
        return reference::Error::bad_input(place_, what);
    }

    /// Throws where elements are no vectors of `components` components.
    void expect_components(unsigned components) const;
    /// Throws where elements are no vertex indices: scalars, unsigned, one behind the other.
    void expect_indices() const;

    /// `count` elements from `first` on, components one behind the other; normalised integers come
    /// as -1 to 1 or 0 to 1. The range has to lie inside.
    void read(std::uint64_t first, std::uint64_t count, float* to) const;
    void read(std::uint64_t first, std::uint64_t count, std::uint32_t* to) const;

 private:
    struct Sparse;
    static constexpr std::uint64_t kFloat = 5126;

    GltfAccessor(GltfDocument& document, const GltfObject& place, std::uint64_t count,
                 std::uint64_t component_type, unsigned components);
    void set_component(const GltfObject& object, std::uint64_t type);
    void set_bytes(const GltfView& view, std::uint64_t offset);
    void read_sparse(GltfDocument& document, const GltfObject& object);
    template <class To>
    void read_as(std::uint64_t first, std::uint64_t count, To* to) const;
    template <class From, class To>
    void convert(const char* from, std::uint64_t count, To* to) const;

    std::string place_;
    std::uint64_t count_ = 0;
    std::uint64_t component_type_ = kFloat;
    unsigned component_size_ = 4;
    unsigned components_ = 1;
    bool is_normalised_ = false;
    bool has_view_ = false;
    GltfBytes bytes_;           ///< from the first element on
    std::uint64_t stride_ = 0;  ///< in bytes, never 0
    std::shared_ptr<const Sparse> sparse_;
};

}  // namespace scotty::scenes
