#include "verify/golden/golden_proposal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "reference/contract/wide_bvh.h"
#include "reference/truth/path_tracer.h"
#include "reference/truth/tracers.h"
#include "scenes/scenes.h"
#include "verify/backends/backend.h"
#include "verify/backends/temporary_capture.h"
#include "verify/capture/capture_format.h"
#include "verify/capture/npy.h"
#include "verify/golden/ledger.h"
#include "verify/golden/pipeline_image.h"
#include "verify/images/image_file.h"
#include "verify/images/image_read.h"
#include "verify/report/report.h"

namespace scotty::verify {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using reference::Error;

namespace {

fs::path entry_path(const fs::path& output, const std::string& name) {
    return output / "entries" / (name + ".json");
}

void make_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw Error::bad_input(folder.string(), "cannot be made: " + error.message());
}

void expect_outside(const fs::path& output, const fs::path& golden) {
    const fs::path inner = fs::weakly_canonical(output);
    const fs::path outer = fs::weakly_canonical(golden);
    const auto [end, rest] = std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end());
    if (end != outer.end()) return;
    throw Error::bad_input(output.string(),
                           "lies in the golden folder, where only approve writes; name another");
}

/// Throws bad_input where there is no golden image to keep.
void keep_image(const GoldenCase& golden, const ProposalSettings& settings) {
    const fs::path from = settings.golden / image_path(golden.name);
    const fs::path to = settings.output / image_path(golden.name);
    make_folder(to.parent_path());
    std::error_code error;
    fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
    if (error) {
        throw Error::bad_input(from.string(), "cannot be kept: " + error.message() +
                                                  "; without --ledger-only it is rendered");
    }
}

void propose_image(const GoldenCase& golden, const reference::Scene& scene,
                   const ProposalSettings& settings) {
    if (settings.ledger_only) return keep_image(golden, settings);
    const ordered_json made_for = settings_of(golden, scene);
    const std::string text = made_for.dump();
    reference::PathTracerOptions options;
    options.threads = settings.threads;
    // By its settings: with others it begins anew, and these can be gone back to.
    options.state = settings.output / "states" /
                    fmt::format("{}-{}.state", golden.name, hash_text(text.data(), text.size()));
    make_folder(options.state.parent_path());
    if (settings.progress) {
        options.progress = [&](std::uint64_t done, std::uint64_t total) {
            settings.progress(golden.name + ": samples of the image", done, total);
        };
    }
    const MeasuredImage image = measured(trace_paths(scene, golden.image, options));
    const fs::path file = settings.output / image_path(golden.name);
    make_folder(file.parent_path());
    write_measured_image(image, file.string(),
                         {{"scotty:scene", golden.scene},
                          {"scotty:scene_hash", made_for["scene_hash"]},
                          {"scotty:parameters", made_for["image"].dump()},
                          {"scotty:generator", made_for["generator"]},
                          {"scotty:embree", reference::EmbreeTracer::version()},
                          {"scotty:commit", settings.commit}});
}

void propose_ledger(const GoldenCase& golden, reference::Scene scene,
                    const ProposalSettings& settings) {
    if (settings.progress) settings.progress(golden.name + ": stages of the ledger", 0, 1);
    reference::WideBvh bvh = build_wide_bvh(scene, bvh_parameters(golden.ledger, settings.threads));
    const TemporaryCapture capture(backend_named("emulator", settings.threads),
                                   {std::move(scene), std::move(bvh), golden.ledger});
    reference::write_file((settings.output / ledger_path(golden.name)).string(),
                          to_text(ledger_of(capture.get())));
}

/// Standard deviation of the mean over all pixels and channels, as a share of it.
double relative_noise(const MeasuredImage& image) {
    double sum = 0.0;
    double variance = 0.0;
    for (std::size_t pixel = 0; pixel < image.mean.size(); ++pixel) {
        for (std::size_t c = 0; c < 3; ++c) {
            sum += image.mean[pixel][c];
            variance += image.variance[pixel][c];
        }
    }
    return sum > 0.0 ? std::sqrt(variance) / sum : 0.0;
}

void compare_images(const MeasuredImage& old, const MeasuredImage& image, Proposal& proposal) {
    proposal.image = Proposal::Change::unchanged;
    if (old.width != image.width || old.height != image.height) {
        proposal.image = Proposal::Change::changed;
        proposal.pixels_changed = image.mean.size();
        return;
    }
    for (std::size_t pixel = 0; pixel < image.mean.size(); ++pixel) {
        if (old.mean[pixel] == image.mean[pixel]) continue;
        proposal.image = Proposal::Change::changed;
        ++proposal.pixels_changed;
        for (std::size_t c = 0; c < 3; ++c) {
            const double change = std::abs(image.mean[pixel][c] - old.mean[pixel][c]);
            proposal.largest_change = std::max(proposal.largest_change, change);
            if (old.variance.empty()) continue;
            const double variance = image.variance[pixel][c] + old.variance[pixel][c];
            if (variance > 0.0) {
                proposal.largest_z = std::max(proposal.largest_z, change / std::sqrt(variance));
            }
        }
    }
    if (old.variance != image.variance) proposal.image = Proposal::Change::changed;
}

/// With what is in the golden folder now. A file that is not there or cannot be read is none.
Proposal compare(const GoldenCase& golden, const ProposalSettings& settings) {
    Proposal proposal;
    proposal.name = golden.name;
    const MeasuredImage image =
        read_image((settings.output / image_path(golden.name)).string()).image;
    proposal.noise = relative_noise(image);
    try {
        compare_images(read_image((settings.golden / image_path(golden.name)).string()).image,
                       image, proposal);
    } catch (const Error&) {
        proposal.image = Proposal::Change::added;
    }
    try {
        const LedgerComparison lines =
            compare_ledgers(read_ledger(settings.golden / ledger_path(golden.name)),
                            read_ledger(settings.output / ledger_path(golden.name)));
        proposal.ledger = lines.passed() ? Proposal::Change::unchanged : Proposal::Change::changed;
        proposal.lines_changed = lines.differing;
        proposal.first_line = lines.sentence;
    } catch (const Error&) {
        proposal.ledger = Proposal::Change::added;
    }
    for (const GoldenFinding& finding : check_golden(settings.golden, {golden}, today())) {
        if (finding.name != golden.name || finding.problem == GoldenProblem::waiver) continue;
        proposal.reason_to_propose =
            fmt::format("{}: {}", to_string(finding.problem), finding.text);
        break;
    }
    return proposal;
}

}  // namespace

const char* to_string(Proposal::Change change) {
    switch (change) {
        case Proposal::Change::added:
            return "added";
        case Proposal::Change::changed:
            return "changed";
        case Proposal::Change::unchanged:
            return "unchanged";
    }
    return "(invalid)";
}

Proposal propose_golden(const GoldenCase& golden, const ProposalSettings& settings) {
    expect_outside(settings.output, settings.golden);
    const reference::Scene scene = scenes::load_scene(golden.scene);
    propose_image(golden, scene, settings);
    propose_ledger(golden, scene, settings);
    GoldenEntry entry;
    entry.name = golden.name;
    entry.settings = settings_of(golden, scene);
    for (const fs::path& file : {image_path(golden.name), ledger_path(golden.name)}) {
        entry.files[file.string()] = checksum(settings.output / file);
    }
    entry.command = settings.command;
    entry.commit = settings.commit;
    entry.made_with = "Embree " + reference::EmbreeTracer::version();
    reference::write_file(entry_path(settings.output, golden.name).string(),
                          to_json(entry).dump(1) + "\n");
    return compare(golden, settings);
}

std::string to_text(const std::vector<Proposal>& proposals) {
    std::string text;
    for (const Proposal& p : proposals) {
        text += fmt::format("{:<10} image {}", p.name, to_string(p.image));
        if (p.image == Proposal::Change::changed) {
            text += fmt::format(" in {} pixels, by up to {:.3g} ({:.1f} standard deviations)",
                                p.pixels_changed, p.largest_change, p.largest_z);
        }
        text += fmt::format(" (noise of its mean {:.3f} %); ledger {}", 100.0 * p.noise,
                            to_string(p.ledger));
        if (p.ledger == Proposal::Change::changed) {
            text += fmt::format(" in {} lines, first {}", p.lines_changed, p.first_line);
        }
        text += '\n';
        if (!p.reason_to_propose.empty()) text += fmt::format("  now {}\n", p.reason_to_propose);
        const bool changes = p.image != Proposal::Change::unchanged ||
                             p.ledger != Proposal::Change::unchanged ||
                             !p.reason_to_propose.empty();
        if (changes) text += fmt::format("  scotty golden approve {} --reason \"...\"\n", p.name);
    }
    return text;
}

ordered_json to_json(const std::vector<Proposal>& proposals) {
    ordered_json out = ordered_json::array();
    for (const Proposal& p : proposals) {
        out.push_back({{"case", p.name},
                       {"image", to_string(p.image)},
                       {"pixels_changed", p.pixels_changed},
                       {"largest_change", p.largest_change},
                       {"largest_z", p.largest_z},
                       {"relative_noise", p.noise},
                       {"ledger", to_string(p.ledger)},
                       {"lines_changed", p.lines_changed},
                       {"first_line", p.first_line},
                       {"now", p.reason_to_propose}});
    }
    return out;
}

namespace {

/// A whole copy or none: under a name of its own beside the target, then renamed.
void copy_by_rename(const fs::path& from, const fs::path& to) {
    make_folder(to.parent_path());
    const fs::path partial = to.string() + ".unfinished";
    std::error_code error;
    fs::copy_file(from, partial, fs::copy_options::overwrite_existing, error);
    if (!error) fs::rename(partial, to, error);
    if (!error) return;
    const std::string why = error.message();
    fs::remove(partial, error);
    throw Error::bad_input(to.string(), "cannot be written: " + why);
}

/// The entry of a proposal, whose files are those that were proposed.
GoldenEntry proposed_entry(const std::string& name, const fs::path& output,
                           const nlohmann::json& settings, std::size_t files) {
    const std::string again = fmt::format("scotty golden propose {}", name);
    const fs::path file = entry_path(output, name);
    std::error_code ignored;
    if (!fs::exists(file, ignored)) {
        throw Error::bad_input(file.string(), "there is no proposal of this case: " + again);
    }
    GoldenEntry entry = parse_entry(file.string(), read_json(file));
    if (entry.name != name || nlohmann::json(entry.settings) != settings) {
        throw Error::bad_input(file.string(),
                               "was proposed for other settings than the case has now: " + again);
    }
    if (entry.files.size() != files) throw Error::bad_input(file.string(), "lists too few files");
    for (const auto& [path, sum] : entry.files) {
        if (checksum(output / path) == sum) continue;
        throw Error::bad_input((output / path).string(),
                               "is not the file that was proposed: " + again);
    }
    return entry;
}

void expect_reason(const std::string& reason) {
    if (reason.find_first_not_of(" \t\n") != std::string::npos) return;
    throw Error::bad_input("--reason", "expected a sentence that says why the truth changes");
}

void take_over(GoldenEntry entry, const fs::path& golden_folder, const fs::path& output,
               const std::string& reason) {
    Manifest manifest = read_manifest(golden_folder);
    std::erase_if(manifest.entries,
                  [&](const GoldenEntry& other) { return other.name == entry.name; });
    entry.reason = reason;
    for (const auto& [path, sum] : entry.files) {
        const fs::path target = golden_folder / path;
        std::error_code ignored;
        if (fs::exists(target, ignored) && checksum(target) == sum) continue;
        copy_by_rename(output / path, target);
    }
    manifest.entries.push_back(std::move(entry));
    write_manifest(golden_folder, manifest);
}

const ordered_json& hash_settings() {
    static const ordered_json settings{{"generator", "hashes of small runs, version 1"}};
    return settings;
}

}  // namespace

void approve_golden(const GoldenCase& golden, const fs::path& golden_folder, const fs::path& output,
                    const std::string& reason) {
    expect_reason(reason);
    const auto settings = settings_of(golden, scenes::load_scene(golden.scene));
    take_over(proposed_entry(golden.name, output, settings, 2), golden_folder, output, reason);
}

HashProposal propose_hashes(const Hashes& hashes, const ProposalSettings& settings) {
    expect_outside(settings.output, settings.golden);
    make_folder(settings.output);
    const fs::path file = settings.output / kHashesFile;
    reference::write_file(file.string(), to_text(hashes));
    GoldenEntry entry;
    entry.name = kHashesName;
    entry.settings = hash_settings();
    entry.files[kHashesFile] = checksum(file);
    entry.command = settings.command;
    entry.commit = settings.commit;
    entry.made_with = "the emulator";
    const fs::path listed = entry_path(settings.output, entry.name);
    make_folder(listed.parent_path());
    reference::write_file(listed.string(), to_json(entry).dump(1) + "\n");

    HashProposal proposal;
    proposal.in_all = hashes.size();
    Hashes old;
    try {
        old = read_hashes(settings.golden / kHashesFile);
    } catch (const Error&) {  // there are none yet
    }
    for (const auto& [what, hash] : hashes) {
        const auto before = old.find(what);
        if (before != old.end() && before->second == hash) continue;
        ++(before == old.end() ? proposal.added : proposal.changed);
        if (proposal.first.empty()) proposal.first = what;
    }
    for (const auto& [what, hash] : old) proposal.gone += hashes.contains(what) ? 0 : 1;
    return proposal;
}

std::string to_text(const HashProposal& proposal) {
    std::string text =
        fmt::format("hashes     {} in all: {} added, {} changed, {} gone", proposal.in_all,
                    proposal.added, proposal.changed, proposal.gone);
    if (!proposal.first.empty()) text += fmt::format("; first {}", proposal.first);
    text += '\n';
    if (proposal.changes()) text += "  scotty golden approve hashes --reason \"...\"\n";
    return text;
}

ordered_json to_json(const HashProposal& proposal) {
    return {{"in_all", proposal.in_all},
            {"added", proposal.added},
            {"changed", proposal.changed},
            {"gone", proposal.gone},
            {"first", proposal.first}};
}

void approve_hashes(const fs::path& golden_folder, const fs::path& output,
                    const std::string& reason) {
    expect_reason(reason);
    take_over(proposed_entry(kHashesName, output, hash_settings(), 1), golden_folder, output,
              reason);
}

std::optional<Hashes> golden_hashes(const fs::path& golden_folder) {
    const Manifest manifest = read_manifest(golden_folder);
    const GoldenEntry* entry = manifest.find(kHashesName);
    if (entry == nullptr) return std::nullopt;
    const fs::path file = golden_folder / kHashesFile;
    const auto listed = entry->files.find(kHashesFile);
    if (listed == entry->files.end() || checksum(file) != listed->second) {
        throw Error::bad_input(
            file.string(), "is not what the manifest says; scotty golden check says what to do");
    }
    return read_hashes(file);
}

}  // namespace scotty::verify
