#include "verify/golden/golden.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "reference/truth/path_tracer.h"
#include "verify/capture/capture_format.h"
#include "verify/capture/npy.h"

namespace scotty::verify {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;
using reference::Error;

namespace {

constexpr const char* kFormat = "cuda-scotty-golden";
constexpr int kManifestVersion = 1;
constexpr const char* kManifest = "manifest.json";

fs::path manifest_path(const fs::path& golden) { return golden / kManifest; }

/// The folder itself or one above that holds golden/manifest.json; empty where none does.
fs::path golden_above(fs::path folder) {
    std::error_code ignored;
    while (true) {
        if (fs::exists(manifest_path(folder / "golden"), ignored)) return folder / "golden";
        const fs::path above = folder.parent_path();
        if (above.empty() || above == folder) return {};
        folder = above;
    }
}

}  // namespace

const GoldenEntry* Manifest::find(const std::string& name) const {
    const auto found = std::find_if(entries.begin(), entries.end(),
                                    [&](const GoldenEntry& entry) { return entry.name == name; });
    return found == entries.end() ? nullptr : &*found;
}

ordered_json settings_of(const GoldenCase& golden, const reference::Scene& scene) {
    const reference::PipelineParameters& p = golden.image;
    return {{"scene", golden.scene},
            {"scene_hash", hex_text(fingerprint(scene))},
            {"generator", fmt::format("path tracer, version {}", reference::kPathTracerVersion)},
            {"image",
             {{"width", p.image_width},
              {"height", p.image_height},
              {"samples", p.spp},
              {"bounces", p.bounces},
              {"lights", p.light_samples > 0 ? "sampled" : "found by paths"},
              {"seed", p.seed}}},
            {"ledger", to_json(golden.ledger)}};
}

fs::path image_path(const std::string& name) { return fs::path("images") / (name + ".exr"); }
fs::path ledger_path(const std::string& name) { return fs::path("ledgers") / (name + ".txt"); }

ordered_json to_json(const GoldenEntry& entry) {
    return {{"name", entry.name},     {"settings", entry.settings},
            {"files", entry.files},   {"command", entry.command},
            {"commit", entry.commit}, {"made_with", entry.made_with},
            {"reason", entry.reason}};
}

GoldenEntry parse_entry(const std::string& where, const json& object) {
    GoldenEntry entry;
    entry.name = text_member(where, object, "name");
    const std::string place = fmt::format("{}: case '{}'", where, entry.name);
    entry.settings = member(place, object, "settings");
    const json& files = member(place, object, "files");
    if (!files.is_object()) throw Error::bad_input(place, "'files': expected an object");
    for (const auto& item : files.items()) {
        // Of this case and no other: approving one must not reach another's files.
        const std::string& file = item.key();
        const bool of_it = entry.name == kHashesName
                               ? file == kHashesFile
                               : file == image_path(entry.name) || file == ledger_path(entry.name);
        if (!of_it) {
            throw Error::bad_input(place, fmt::format("'files': '{}' is not of this case", file));
        }
        hex_member(place, files, file.c_str());
        entry.files[file] = item.value();
    }
    entry.command = text_member(place, object, "command");
    entry.commit = text_member(place, object, "commit");
    entry.made_with = text_member(place, object, "made_with");
    entry.reason = text_member(place, object, "reason");
    return entry;
}

Manifest read_manifest(const fs::path& golden) {
    const fs::path file = manifest_path(golden);
    const json object = read_json(file);
    expect_format(file, object, kFormat, kManifestVersion);
    const std::string place = file.string();
    const json& cases = member(place, object, "cases");
    if (!cases.is_array()) throw Error::bad_input(place, "'cases': expected a list");
    Manifest manifest;
    for (const json& item : cases) {
        GoldenEntry entry = parse_entry(place, item);
        if (manifest.find(entry.name) != nullptr) {
            throw Error::bad_input(place, fmt::format("case '{}' is there twice", entry.name));
        }
        manifest.entries.push_back(std::move(entry));
    }
    return manifest;
}

void write_manifest(const fs::path& golden, const Manifest& manifest) {
    std::vector<GoldenEntry> entries = manifest.entries;
    std::sort(entries.begin(), entries.end(),
              [](const GoldenEntry& a, const GoldenEntry& b) { return a.name < b.name; });
    ordered_json cases = ordered_json::array();
    for (const GoldenEntry& entry : entries) cases.push_back(to_json(entry));
    const ordered_json object{{"format", kFormat}, {"version", kManifestVersion}, {"cases", cases}};
    reference::write_file(manifest_path(golden), object.dump(1) + "\n");
}

std::string checksum(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    if (!in.is_open() || in.bad()) throw Error::bad_input(file.string(), "cannot be read");
    return hash_text(bytes.data(), bytes.size());
}

fs::path find_golden_folder() {
    std::error_code ignored;
    const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
    fs::path installed = program.parent_path().parent_path() / "share/cuda-scotty/golden";
    if (fs::exists(installed / "manifest.json", ignored)) return installed;
    for (const fs::path& start : {program.parent_path(), fs::current_path(ignored)}) {
        if (fs::path found = golden_above(start); !found.empty()) return found;
    }
    throw Error::bad_input("golden/manifest.json",
                           "found neither beside or above the program nor at or above the current "
                           "folder; name the folder with --golden (scotty verify --no-golden goes "
                           "without)");
}

const char* to_string(GoldenProblem problem) {
    switch (problem) {
        case GoldenProblem::missing:
            return "missing";
        case GoldenProblem::orphaned:
            return "orphaned";
        case GoldenProblem::stale:
            return "stale";
        case GoldenProblem::corrupted:
            return "corrupted";
        case GoldenProblem::waiver:
            return "waiver";
    }
    return "(invalid)";
}

}  // namespace scotty::verify
