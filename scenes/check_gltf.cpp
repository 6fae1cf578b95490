#include <array>
#include <cstdint>
#include <cstring>
#include <utility>

#include "reference/base/error.h"
#include "scenes/file_checks.h"

namespace scotty::scenes {

using nlohmann::json;
using reference::Error;

namespace {

constexpr std::uint64_t kNoIndex = ~std::uint64_t{0};

/// The JSON chunk of a .glb, or the file itself.
std::string json_text(const std::string& path, std::string bytes) {
    if (bytes.rfind("glTF", 0) != 0) return bytes;
    std::array<std::uint32_t, 5> header{};
    if (bytes.size() < sizeof header) throw Error::bad_input(path, "a .glb without a chunk");
    std::memcpy(header.data(), bytes.data(), sizeof header);
    if (header[2] > bytes.size()) {
        throw Error::bad_input(
            path, fmt::format("expected {} bytes, found {} (truncated?)", header[2], bytes.size()));
    }
    if (header[3] > bytes.size() - sizeof header) {
        throw Error::bad_input(path, "the JSON chunk is longer than the file (truncated?)");
    }
    return bytes.substr(sizeof header, header[3]);
}

class GltfChecker {
 public:
    GltfChecker(std::string path, const json& root) : path_(std::move(path)), root_(root) {}

    void check() const {
        for (std::size_t i = 0; i < list("bufferViews").size(); ++i) check_view(i);
        for (std::size_t i = 0; i < list("accessors").size(); ++i) check_accessor(i);
        check_nodes();
    }

 private:
    [[noreturn]] void fail(const char* kind, std::size_t index, const std::string& what) const {
        throw Error::bad_input(fmt::format("{}: {}[{}]", path_, kind, index), what);
    }

    const json& list(const char* kind) const {
        static const json empty = json::array();
        const auto found = root_.find(kind);
        if (found == root_.end()) return empty;
        if (!found->is_array()) throw Error::bad_input(path_, fmt::format("{}: no array", kind));
        for (const json& entry : *found) {
            if (!entry.is_object()) {
                throw Error::bad_input(path_, fmt::format("{}: expected objects", kind));
            }
        }
        return *found;
    }

    std::uint64_t whole(const char* kind, std::size_t index, const char* field,
                        std::uint64_t standard) const {
        const json& entry = list(kind)[index];
        const auto found = entry.find(field);
        if (found == entry.end()) return standard;
        if (!found->is_number_unsigned() || found->get<std::uint64_t>() > (1ull << 48)) {
            fail(kind, index,
                 fmt::format("{}: expected a whole number, found {}", field, found->dump()));
        }
        return found->get<std::uint64_t>();
    }

    void check_reference(const char* kind, std::size_t index, const char* field,
                         std::uint64_t value, const char* target) const {
        if (value < list(target).size()) return;
        fail(kind, index,
             fmt::format("{} {} out of range, there are {} {}", field, value, list(target).size(),
                         target));
    }

    void check_view(std::size_t i) const {
        const std::uint64_t buffer = whole("bufferViews", i, "buffer", kNoIndex);
        check_reference("bufferViews", i, "buffer", buffer, "buffers");
        const std::uint64_t end =
            whole("bufferViews", i, "byteOffset", 0) + whole("bufferViews", i, "byteLength", 0);
        const std::uint64_t length = whole("buffers", buffer, "byteLength", 0);
        if (end > length) {
            fail("bufferViews", i, fmt::format("ends at byte {}, its buffer has {}", end, length));
        }
    }

    void check_accessor(std::size_t i) const {
        const std::uint64_t view = whole("accessors", i, "bufferView", kNoIndex);
        if (view == kNoIndex) return;  // all zero, or sparse
        check_reference("accessors", i, "bufferView", view, "bufferViews");
        const std::uint64_t size = element_size(i);
        const std::uint64_t stride = whole("bufferViews", view, "byteStride", size);
        const std::uint64_t count = whole("accessors", i, "count", 0);
        if (count == 0) fail("accessors", i, "count: expected at least 1");
        const std::uint64_t end =
            whole("accessors", i, "byteOffset", 0) + (count - 1) * stride + size;
        const std::uint64_t length = whole("bufferViews", view, "byteLength", 0);
        if (count > length || end > length) {
            fail("accessors", i,
                 fmt::format("{} elements end at byte {}, the view has {}", count, end, length));
        }
    }

    std::uint64_t element_size(std::size_t i) const {
        const std::uint64_t component = whole("accessors", i, "componentType", 0);
        std::uint64_t bytes = 4;
        if (component == 5120 || component == 5121) bytes = 1;
        if (component == 5122 || component == 5123) bytes = 2;
        const json& accessor = list("accessors")[i];
        const auto type = accessor.find("type");
        const std::array<std::pair<const char*, std::uint64_t>, 7> counts = {{{"SCALAR", 1},
                                                                              {"VEC2", 2},
                                                                              {"VEC3", 3},
                                                                              {"VEC4", 4},
                                                                              {"MAT2", 4},
                                                                              {"MAT3", 9},
                                                                              {"MAT4", 16}}};
        for (const auto& [name, count] : counts) {
            if (type != accessor.end() && *type == name) return bytes * count;
        }
        fail("accessors", i, "type: expected SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4");
    }

    /// A node may be the child of one other at most, and not below itself.
    void check_nodes() const {
        const std::size_t count = list("nodes").size();
        std::vector<std::uint64_t> parent(count, kNoIndex);
        for (std::size_t i = 0; i < count; ++i) {
            const json& node = list("nodes")[i];
            const auto children = node.find("children");
            if (children == node.end()) continue;
            for (const json& child : *children) {
                const std::uint64_t index =
                    child.is_number_unsigned() ? child.get<std::uint64_t>() : kNoIndex;
                check_reference("nodes", i, "child", index, "nodes");
                if (parent[index] != kNoIndex) {
                    fail("nodes", index, "is the child of two nodes");
                }
                parent[index] = i;
            }
        }
        for (std::size_t i = 0; i < count; ++i) {
            std::size_t steps = 0;
            for (std::uint64_t at = parent[i]; at != kNoIndex; at = parent[at]) {
                if (++steps > 512) fail("nodes", i, "more than 512 nodes deep, or in a circle");
            }
        }
    }

    std::string path_;
    const json& root_;
};

bool is_supported(const std::string& extension) {
    for (const char* name :
         {"KHR_lights_punctual", "KHR_materials_transmission", "KHR_materials_ior"}) {
        if (extension == name) return true;
    }
    return false;
}

}  // namespace

json check_gltf(const std::string& path, Notes& notes) {
    json root = json::parse(json_text(path, read_file(path)), nullptr, false);
    if (root.is_discarded() || !root.is_object()) {
        throw Error::bad_input(path, "not well-formed glTF (JSON); the file may be truncated");
    }
    try {
        GltfChecker(path, root).check();
        gltf_triangles(root);
    } catch (const json::exception& wrong) {
        throw Error::bad_input(path, fmt::format("not glTF as specified: {}", wrong.what()));
    }
    const auto used = root.find("extensionsUsed");
    if (used != root.end() && used->is_array()) {
        for (const json& extension : *used) {
            if (!extension.is_string() || is_supported(extension.get<std::string>())) continue;
            notes.add(fmt::format("the extension {} is not supported: left out",
                                  extension.get<std::string>()));
        }
    }
    return root;
}

std::uint64_t gltf_triangles(const json& root) {
    constexpr int kTriangles = 4;
    const json accessors = root.value("accessors", json::array());
    std::uint64_t total = 0;
    for (const json& mesh : root.value("meshes", json::array())) {
        for (const json& primitive : mesh.value("primitives", json::array())) {
            if (!primitive.is_object() || primitive.value("mode", kTriangles) != kTriangles)
                continue;
            const json attributes = primitive.value("attributes", json::object());
            const std::uint64_t none = kNoIndex;
            const std::uint64_t corners =
                primitive.value("indices", attributes.value("POSITION", none));
            if (corners >= accessors.size()) continue;
            total += accessors[corners].value("count", std::uint64_t{0}) / 3;
        }
    }
    return total;
}

}  // namespace scotty::scenes
