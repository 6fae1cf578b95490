/// The format of captures as they are written: hashes, arrays, JSON, and a directory that appears
/// whole. C++17 without dependencies: it is the first half of capture_writer.h.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace scotty::capture {

constexpr std::uint32_t kNothing = 0xffffffffu;  ///< no primitive, no node, no ray
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// `where` is a file or an element.
class Error : public std::runtime_error {
 public:
    Error(std::string where, std::string what)
        : std::runtime_error(where + ": " + what),
          where_(std::move(where)),
          what_(std::move(what)) {}
    const std::string& where() const { return where_; }
    const std::string& complaint() const { return what_; }

 private:
    std::string where_, what_;
};

enum class Type { uint8, uint32, uint64, float32 };
inline const char* name_of(Type type) {
    constexpr std::array<const char*, 4> kNames{"uint8", "uint32", "uint64", "float32"};
    return kNames[static_cast<std::size_t>(type)];
}
inline std::size_t size_of(Type type) {
    return type == Type::uint8 ? 1 : type == Type::uint64 ? 8 : 4;
}

/// XXH64 with seed 0 (https://github.com/Cyan4973/xxHash/blob/dev/doc/xxhash_spec.md).
inline std::uint64_t hash(const void* data, std::size_t bytes) {
    constexpr std::uint64_t k1 = 0x9e3779b185ebca87u, k2 = 0xc2b2ae3d27d4eb4fu,
                            k3 = 0x165667b19e3779f9u, k4 = 0x85ebca77c2b2ae63u,
                            k5 = 0x27d4eb2f165667c5u;
    const auto turn = [](std::uint64_t x, int by) { return x << by | x >> (64 - by); };
    const auto round = [&](std::uint64_t sum, std::uint64_t lane) {
        return turn(sum + lane * k2, 31) * k1;
    };
    const auto word = [](const unsigned char* from) {
        std::uint64_t value;
        std::memcpy(&value, from, sizeof value);
        return value;
    };
    const auto* at = static_cast<const unsigned char*>(data);
    std::size_t left = bytes;
    std::uint64_t sum = k5;
    if (left >= 32) {
        std::array<std::uint64_t, 4> lanes{k1 + k2, k2, 0, 0 - k1};
        for (; left >= 32; at += 32, left -= 32) {
            for (std::size_t i = 0; i < 4; ++i) lanes[i] = round(lanes[i], word(at + 8 * i));
        }
        sum = turn(lanes[0], 1) + turn(lanes[1], 7) + turn(lanes[2], 12) + turn(lanes[3], 18);
        for (const std::uint64_t lane : lanes) sum = (sum ^ round(0, lane)) * k1 + k4;
    }
    sum += bytes;
    for (; left >= 8; at += 8, left -= 8) sum = turn(sum ^ round(0, word(at)), 27) * k1 + k4;
    if (left >= 4) {
        std::uint32_t half;
        std::memcpy(&half, at, sizeof half);
        sum = turn(sum ^ half * k1, 23) * k2 + k3;
        at += 4;
        left -= 4;
    }
    for (; left > 0; ++at, --left) sum = turn(sum ^ *at * k5, 11) * k1;
    sum = (sum ^ sum >> 33) * k2;
    sum = (sum ^ sum >> 29) * k3;
    return sum ^ sum >> 32;
}
/// 16 hexadecimal digits.
inline std::string hex(std::uint64_t value) {
    std::string text(16, '0');
    for (std::size_t i = 16; i-- > 0; value >>= 4) text[i] = "0123456789abcdef"[value & 15u];
    return text;
}
inline std::string hash_text(const void* data, std::size_t bytes) { return hex(hash(data, bytes)); }

inline void write_file(const std::filesystem::path& file, const std::string& start,
                       const void* data = nullptr, std::size_t bytes = 0) {
    std::ofstream out(file, std::ios::binary);
    out.write(start.data(), static_cast<std::streamsize>(start.size()));
    if (bytes != 0) {
        out.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
    }
    out.close();
    if (!out) {
        throw Error(file.string(),
                    "cannot be written (is the disk full, or the folder read-only?)");
    }
}

/// What precedes the data in a .npy file of version 1.0; a multiple of 64 bytes.
inline std::string npy_header(Type type, const std::vector<std::size_t>& shape) {
    constexpr std::array<const char*, 4> kTypes{"|u1", "<u4", "<u8", "<f4"};
    std::string text = std::string("{'descr': '") + kTypes[static_cast<std::size_t>(type)] +
                       "', 'fortran_order': False, 'shape': (";
    for (std::size_t i = 0; i < shape.size(); ++i) {
        text += (i == 0 ? "" : ", ") + std::to_string(shape[i]);
    }
    text += shape.size() == 1 ? ",), }" : "), }";
    text.append((64 - (11 + text.size()) % 64) % 64, ' ');
    text += '\n';
    std::string start("\x93NUMPY\x01\x00", 8);
    start += static_cast<char>(text.size() & 0xffu);
    start += static_cast<char>(text.size() >> 8);
    return start + text;
}

/// JSON text, a line for each element.
class Json {
 public:
    static std::string quoted(const std::string& text) {
        std::string out = "\"";
        for (const char c : text) {
            constexpr const char* kShort = "\b\f\n\r\t\"\\";
            const char* const found = c == '\0' ? nullptr : std::strchr(kShort, c);
            if (found != nullptr) {
                out += {'\\', "bfnrt\"\\"[found - kShort]};
            } else if (static_cast<unsigned char>(c) < 0x20) {
                out += "\\u" + hex(static_cast<unsigned char>(c)).substr(12);
            } else {
                out += c;
            }
        }
        return out + '"';
    }
    Json& open(char bracket) {
        before_value();
        text_ += bracket;
        elements_.push_back(0);
        return *this;
    }
    Json& close(char bracket) {
        const bool empty = elements_.back() == 0;
        elements_.pop_back();
        if (!empty) text_ += '\n' + std::string(elements_.size(), ' ');
        text_ += bracket;
        return *this;
    }
    Json& key(const std::string& name) {
        before_value();
        text_ += quoted(name) + ": ";
        has_key_ = true;
        return *this;
    }
    Json& raw(const std::string& value) {
        before_value();
        text_ += value;
        return *this;
    }
    Json& text(const std::string& value) { return raw(quoted(value)); }
    Json& number(std::uint64_t value) { return raw(std::to_string(value)); }
    Json& boolean(bool value) { return raw(value ? "true" : "false"); }
    const std::string& result() const { return text_; }

 private:
    void before_value() {
        if (!has_key_ && !elements_.empty()) {
            text_ += elements_.back()++ == 0 ? "\n" : ",\n";
            text_.append(elements_.size(), ' ');
        }
        has_key_ = false;
    }
    std::string text_;
    std::vector<std::size_t> elements_;  ///< so far, of each open bracket
    bool has_key_ = false;
};

constexpr const char* kCaptureFormat = "cuda-scotty-capture";
constexpr const char* kInputFormat = "cuda-scotty-input";
constexpr int kVersion = 1;

/// A directory that appears whole or not at all: written under another name beside its target, and
/// renamed by finish(). A target that is there is replaced if it is a capture or empty.
class Directory {
 public:
    explicit Directory(const std::filesystem::path& target) : target_(clean(target)) {
        partial_ = beside("partial");
        expect_replaceable();
        std::error_code error;
        std::filesystem::remove_all(partial_, error);
        if (!std::filesystem::create_directories(partial_, error)) {
            throw Error(partial_.string(), "the directory cannot be made: " + error.message());
        }
    }
    ~Directory() {
        std::error_code ignored;
        if (!finished_) std::filesystem::remove_all(partial_, ignored);
    }
    Directory(const Directory&) = delete;
    Directory& operator=(const Directory&) = delete;

    const std::filesystem::path& path() const { return partial_; }  ///< where to write
    void finish() {
        expect_replaceable();
        const std::filesystem::path old = beside("old");
        std::error_code error;
        const bool replaces = std::filesystem::exists(target_, error);
        if (replaces) std::filesystem::rename(target_, old, error);
        if (!error) std::filesystem::rename(partial_, target_, error);
        if (error) {
            throw Error(target_.string(),
                        "the finished capture cannot be moved here: " + error.message());
        }
        finished_ = true;
        if (replaces) std::filesystem::remove_all(old, error);
    }

 private:
    static std::filesystem::path clean(const std::filesystem::path& path) {
        const std::filesystem::path whole = std::filesystem::absolute(path).lexically_normal();
        return whole.has_filename() ? whole : whole.parent_path();
    }
    std::filesystem::path beside(const char* what) const {
        static const std::string kOwn = std::to_string(std::random_device{}());
        return target_.parent_path() /
               ("." + target_.filename().string() + "." + what + "-" + kOwn);
    }
    static bool is_capture(const std::filesystem::path& directory) {
        std::ifstream in(directory / "index.json", std::ios::binary);
        std::string start(4096, '\0');
        in.read(start.data(), static_cast<std::streamsize>(start.size()));
        const std::size_t at = start.find("\"format\"");
        if (at == std::string::npos) return false;
        const std::size_t value = start.find_first_not_of(": \t\r\n", at + 8);
        return value != std::string::npos && start.compare(value, std::strlen(kCaptureFormat) + 2,
                                                           Json::quoted(kCaptureFormat)) == 0;
    }
    void expect_replaceable() const {
        std::error_code error;
        if (!std::filesystem::exists(target_, error)) return;
        if (std::filesystem::is_directory(target_, error) &&
            (std::filesystem::is_empty(target_, error) || is_capture(target_))) {
            return;
        }
        throw Error(target_.string(),
                    "exists and is not a capture, so it is not replaced; name another directory "
                    "or remove it");
    }

    std::filesystem::path target_, partial_;
    bool finished_ = false;
};

/// A buffer of a stage, as the index names it.
struct StoredBuffer {
    std::string name;
    Type type = Type::uint32;
    std::vector<std::size_t> shape;
    std::string meaning, order = "ordered", file, hash, canonical_hash;
};
/// "buffers/0123456789abcdef.npy": equal bytes of another type or shape are another file.
inline std::string file_of(const StoredBuffer& buffer) {
    const std::string address = npy_header(buffer.type, buffer.shape) + buffer.hash;
    return "buffers/" + hash_text(address.data(), address.size()) + ".npy";
}
struct Stage {
    std::string name, kind;
    std::uint32_t launch = 0, batch = 0;
    std::uint32_t bounce = kNothing, light = kNothing, level = kNothing;  ///< kNothing: none
    std::uint32_t blocks = 0, threads = 0;
    std::vector<StoredBuffer> inputs, outputs;
};
struct Index {
    std::string backend;
    std::vector<std::pair<std::string, std::string>> parameters;    ///< their values as JSON
    std::string scene, source, scene_fingerprint, bvh_fingerprint;  ///< empty: not known
    int width = 0;
    std::uint32_t levels = 0;
    bool several_batches = false;
    std::vector<std::string> patterns;
    bool foreign = false;  ///< written by another program: it has ids and arithmetic of its own
    bool culls = false;    ///< of a foreign one: rays that have a hit are not pushed on behind it
    std::vector<Stage> stages;
};

namespace detail {

inline void add_fingerprint(Json& json, const std::string& fingerprint) {
    json.key("fingerprint");
    fingerprint.empty() ? json.raw("null") : json.text(fingerprint);
}
inline void add_parameters(Json& json, const Index& index) {
    json.key("parameters").open('{');
    for (const auto& [name, value] : index.parameters) json.key(name).raw(value);
    json.close('}');
}
inline void add_buffers(Json& json, const char* name, const std::vector<StoredBuffer>& buffers) {
    json.key(name).open('[');
    for (const StoredBuffer& b : buffers) {
        json.open('{').key("name").text(b.name).key("type").text(name_of(b.type));
        json.key("shape").open('[');
        for (const std::size_t size : b.shape) json.number(size);
        json.close(']').key("meaning").text(b.meaning).key("order").text(b.order);
        json.key("file").text(b.file).key("hash").text(b.hash);
        json.key("canonical_hash").text(b.canonical_hash).close('}');
    }
    json.close(']');
}

}  // namespace detail

/// The text of index.json.
inline std::string text_of(const Index& index) {
    Json json;
    json.open('{').key("format").text(kCaptureFormat).key("version").number(kVersion);
    json.key("backend").text(index.backend);
    detail::add_parameters(json, index);
    json.key("scene").open('{').key("name").text(index.scene).key("source").text(index.source);
    detail::add_fingerprint(json, index.scene_fingerprint);
    json.close('}').key("bvh").open('{');
    detail::add_fingerprint(json, index.bvh_fingerprint);
    json.key("width").number(static_cast<std::uint64_t>(index.width));
    json.key("levels").number(index.levels).close('}');
    json.key("several_batches").boolean(index.several_batches).key("patterns").open('[');
    for (const std::string& pattern : index.patterns) json.text(pattern);
    json.close(']');
    if (index.foreign) json.key("foreign").open('{').key("culls").boolean(index.culls).close('}');
    json.key("stages").open('[');
    for (const Stage& s : index.stages) {
        json.open('{').key("name").text(s.name).key("kind").text(s.kind);
        const auto place = [&](const char* name, std::uint32_t value) {
            json.key(name);
            value == kNothing ? json.raw("null") : json.number(value);
        };
        json.key("launch").number(s.launch).key("batch").number(s.batch);
        place("bounce", s.bounce);
        place("light", s.light);
        place("level", s.level);
        json.key("blocks").number(s.blocks).key("threads").number(s.threads);
        detail::add_buffers(json, "inputs", s.inputs);
        detail::add_buffers(json, "outputs", s.outputs);
        json.close('}');
    }
    return json.close(']').close('}').result() + "\n";
}

/// Writes the arrays of input/, and input.json last.
class InputFolder {
 public:
    /// Makes the folder.
    explicit InputFolder(std::filesystem::path folder) : folder_(std::move(folder)) {
        std::error_code error;
        std::filesystem::create_directories(folder_, error);
        if (error)
            throw Error(folder_.string(), "the directory cannot be made: " + error.message());
    }
    void add(const std::string& name, Type type, const std::vector<std::size_t>& shape,
             const void* data, const std::string& meaning) {
        std::size_t bytes = size_of(type);
        for (const std::size_t size : shape) bytes *= size;
        write_file(folder_ / (name + ".npy"), npy_header(type, shape), data, bytes);
        arrays_.push_back({name, meaning, hash_text(data, bytes)});
    }
    /// `columns`: the names of the columns of a table, by the table's name.
    void finish(const Index& index,
                const std::vector<std::pair<std::string, std::vector<std::string>>>& columns) {
        Json json;
        json.open('{').key("format").text(kInputFormat).key("version").number(kVersion);
        detail::add_parameters(json, index);
        json.key("scene").open('{').key("name").text(index.scene).key("source").text(index.source);
        detail::add_fingerprint(json, index.scene_fingerprint);
        json.close('}').key("bvh").open('{');
        json.key("width").number(static_cast<std::uint64_t>(index.width));
        json.key("levels").number(index.levels);
        detail::add_fingerprint(json, index.bvh_fingerprint);
        json.close('}').key("arrays").open('{');
        for (const auto& [name, meaning, sum] : arrays_) {
            json.key(name).open('{').key("file").text(name + ".npy");
            json.key("meaning").text(meaning).key("hash").text(sum).close('}');
        }
        json.close('}');
        for (const auto& [table, names] : columns) {
            json.key(table).open('[');
            for (const std::string& name : names) json.text(name);
            json.close(']');
        }
        write_file(folder_ / "input.json", json.close('}').result() + "\n");
    }

 private:
    std::filesystem::path folder_;
    std::vector<std::array<std::string, 3>> arrays_;  ///< name, meaning, hash
};

}  // namespace scotty::capture
