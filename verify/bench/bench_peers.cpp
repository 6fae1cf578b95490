#include "verify/bench/bench_peers.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <utility>

#include "reference/base/error.h"
#include "verify/base/ask.h"
#include "verify/oracles/ray_compare.h"

namespace scotty::verify {

namespace fs = std::filesystem;
using reference::Error;

namespace {

/// What a peer printed.
struct Answer {
    std::vector<double> seconds;
    std::string last_line;  ///< that is none of these
    int exit_code = -1;
};

/// X of "seconds X" where it is a time.
std::optional<double> time_in(const std::string& line) {
    std::istringstream words(line);
    std::string word, rest;
    double value = 0.0;
    if (!(words >> word >> value) || word != "seconds" || words >> rest) return {};
    if (!std::isfinite(value) || value <= 0.0) return {};
    return value;
}

Answer answer_of(const std::string& command) {
    Answer out;
    std::istringstream lines(output_of(command + " 2>&1; printf '\\nexit code %s\\n' $?"));
    for (std::string line; std::getline(lines, line);) {
        if (const auto seconds = time_in(line)) {
            out.seconds.push_back(*seconds);
        } else if (line.rfind("exit code ", 0) == 0) {
            out.exit_code = std::atoi(line.c_str() + 10);
        } else if (!line.empty()) {
            out.last_line = line;
        }
    }
    return out;
}

std::string without_time(const Answer& answer, int repeats) {
    const std::string said =
        answer.last_line.empty() ? "" : fmt::format("; its last line: {}", answer.last_line);
    if (answer.exit_code != 0) return fmt::format("exit code {}{}", answer.exit_code, said);
    return fmt::format("{} lines \"seconds X\", expected {}{}", answer.seconds.size(), repeats,
                       said);
}

nlohmann::json to_json(const PeerRays& kind, const Spread& ours) {
    nlohmann::json out{{"kind", kind.kind}, {"rays", kind.rays}};
    if (!kind.failure.empty()) {
        out["failure"] = kind.failure;
        return out;
    }
    out.update({{"seconds", kind.seconds.median},
                {"spread", to_json(kind.seconds)},
                {"rays_per_second", kind.rate()},
                {"ratio", kind.seconds.median / ours.median},
                {"wrong_hits", kind.wrong},
                {"excused_hits", kind.excused}});
    return out;
}

std::string row(const std::string& name, const PeerRays& kind, const Spread& ours) {
    std::string out = fmt::format("{:<16} {:<10}", name, kind.kind);
    if (!kind.failure.empty()) return out + " failed: " + kind.failure + "\n";
    return out + fmt::format(" {:>12.3f} {:>7.1f} {:>10.3f} {:>8} {:>8}\n", kind.rate() * 1e-6,
                             100 * kind.seconds.relative(), kind.seconds.median / ours.median,
                             kind.wrong, kind.excused);
}

}  // namespace

PeerRays Peer::all() const {
    PeerRays out;
    out.kind = "all";
    for (const PeerRays& kind : kinds) {
        out.rays += kind.rays;
        out.seconds = out.seconds + kind.seconds;
        out.wrong += kind.wrong;
        out.excused += kind.excused;
        if (out.failure.empty() && !kind.failure.empty()) {
            out.failure = kind.kind + ": " + kind.failure;
        }
    }
    return out;
}

std::vector<std::string> peer_names(const fs::path& folder) {
    std::vector<std::string> names;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator(folder, failed)) {
        if (entry.is_regular_file() && access(entry.path().c_str(), X_OK) == 0) {
            names.push_back(entry.path().filename().string());
        }
    }
    if (failed) throw Error::bad_input(folder.string(), failed.message());
    if (names.empty()) {
        throw Error::bad_input(folder.string(),
                               "no executable file in it; every one would be a peer, started as "
                               "PEER SCENE.scn RAYS.ray HITS WARM_UPS REPEATS "
                               "(docs/benchmarks.md)");
    }
    std::sort(names.begin(), names.end());
    return names;
}

PeerRuns::PeerRuns(const fs::path& folder, const reference::Scene& scene,
                   const BenchSettings& settings)
    : folder_(fs::absolute(folder)), scene_(scene), settings_(settings) {
    for (const std::string& name : peer_names(folder)) peers_.push_back({name, {}});
    fs::create_directories(scratch_.path());
    write_scene_file(scratch_.path() / "scene.scn", scene);
}

void PeerRuns::run(const std::string& kind, const RayFile& rays,
                   std::span<const reference::HitCandidate> expected) {
    write_rays(scratch_.path() / "rays.ray", rays);
    for (Peer& peer : peers_) {
        if (settings_.progress) settings_.progress(fmt::format("{} rays, {}", kind, peer.name));
        peer.kinds.push_back(run_one(peer, kind, rays, expected));
    }
}

PeerRays PeerRuns::run_one(const Peer& peer, const std::string& kind, const RayFile& rays,
                           std::span<const reference::HitCandidate> expected) const {
    PeerRays out;
    out.kind = kind;
    out.rays = rays.rays.size();
    const fs::path hits_file = scratch_.path() / "hits";
    fs::remove(hits_file);
    const auto word = [](const fs::path& path) { return shell_word(path.string()); };
    const Answer answer = answer_of(fmt::format("{} {} {} {} {} {}", word(folder_ / peer.name),
                                                word(scratch_.path() / "scene.scn"),
                                                word(scratch_.path() / "rays.ray"), word(hits_file),
                                                settings_.warm_ups, settings_.repeats));
    if (answer.exit_code != 0 ||
        answer.seconds.size() != static_cast<std::size_t>(settings_.repeats)) {
        out.failure = without_time(answer, settings_.repeats);
        return out;
    }
    try {
        std::vector<reference::HitCandidate> hits = read_hits(hits_file);
        if (hits.size() != rays.rays.size()) {
            out.failure = fmt::format("{} hits for {} rays", hits.size(), rays.rays.size());
            return out;
        }
        if (rays.any_hit) {
            for (reference::HitCandidate& hit : hits) hit.t = 0.0f;  // any tracer's own choice
        }
        const HitComparison compared = compare_hits(scene_, rays, hits, expected);
        out.wrong = compared.ours_wrong;
        out.excused = compared.ties + compared.grazing;
    } catch (const Error& error) {
        out.failure = error.what();
        return out;
    }
    out.seconds = spread_of(answer.seconds);
    return out;
}

std::string table(const std::vector<Peer>& peers, std::span<const Spread> ours) {
    std::string out = fmt::format("{:<16} {:<10} {:>12} {:>7} {:>10} {:>8} {:>8}\n", "peer", "rays",
                                  "M/s", "IQR %", "ours/peer", "wrong", "excused");
    for (const Peer& peer : peers) {
        for (std::size_t i = 0; i < peer.kinds.size(); ++i) {
            out += row(peer.name, peer.kinds[i], ours[i]);
        }
        out += row(peer.name, peer.all(), ours.back());
    }
    return out;
}

nlohmann::json to_json(const std::vector<Peer>& peers, std::span<const Spread> ours) {
    nlohmann::json out = nlohmann::json::array();
    for (const Peer& peer : peers) {
        nlohmann::json kinds = nlohmann::json::array();
        for (std::size_t i = 0; i < peer.kinds.size(); ++i) {
            kinds.push_back(to_json(peer.kinds[i], ours[i]));
        }
        out.push_back(
            {{"name", peer.name}, {"rays", kinds}, {"all_rays", to_json(peer.all(), ours.back())}});
    }
    return out;
}

}  // namespace scotty::verify
