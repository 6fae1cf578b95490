/// A ray's history: as a story, and as rows.
#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "verify/base/json_number.h"
#include "verify/capture/failure.h"
#include "verify/queues/queues_view.h"

namespace scotty::verify {

using nlohmann::ordered_json;
using reference::kNone;

namespace {

std::string hit_text(const reference::HitCandidate& hit) {
    return fmt::format("primitive {} at t {}", hit.primitive, exact(hit.t));
}

std::string child_text(const Visit& visit, const ChildVisit& child) {
    std::string text = fmt::format("{:<7}node {}", to_string(child.outcome), child.node);
    if (child.entry) text += fmt::format(": enters at {}", exact(*child.entry));
    if (child.outcome == Outcome::culled && visit.minimum) {
        text += fmt::format(", beyond the minimum {}", exact(*visit.minimum));
    }
    if (child.position) text += fmt::format(" (entry {} there)", *child.position);
    if (child.outcome == Outcome::lost) text += ", but is not in its queue";
    if (child.times > 1) text += fmt::format(", {} times in its queue", child.times);
    if (child.outcome == Outcome::extra && child.times == 1) text += ", but must not be there";
    return text;
}

std::string leaf_text(const LeafVisit& visit, std::optional<float> minimum) {
    switch (visit.leaf_outcome) {
        case LeafOutcome::none:
            return "no triangle is hit";
        case LeafOutcome::beyond:
            return fmt::format("{}, beyond the minimum {}", hit_text(visit.closest),
                               exact(minimum.value_or(reference::kInfinity)));
        case LeafOutcome::passed:
            return hit_text(visit.closest) + ", but there was a nearer one";
        case LeafOutcome::lost:
            return hit_text(visit.closest) + ", but it is not in the ray's buffer";
        case LeafOutcome::buffered:
        case LeafOutcome::other:
            break;
    }
    std::string text;
    for (const GatheredHit& hit : visit.hits) {
        text += fmt::format("{}buffered {} in slot {}{}", text.empty() ? "" : "; ",
                            hit_text(hit.hit), hit.slot, hit.won ? ": won" : "");
    }
    if (visit.leaf_outcome == LeafOutcome::other) {
        text += "; its closest is " + hit_text(visit.closest);
    }
    return text;
}

void tell(std::string& text, const Visit& visit) {
    text += fmt::format("    level {} node {}{}: entry {}, block {} thread {}", visit.level,
                        visit.node, visit.subtree ? " (subtree)" : (visit.leaf ? " (leaf)" : ""),
                        visit.position, visit.block, visit.thread);
    if (visit.minimum) text += fmt::format(", minimum {}", exact(*visit.minimum));
    text += fmt::format("  [launch {}]\n", visit.launch);
    if (visit.leaf) {
        text += "      " + leaf_text(visit, visit.minimum) + "\n";
        return;
    }
    std::string missed;
    for (const ChildVisit& child : visit.children) {
        if (child.outcome == Outcome::missed) {
            missed += fmt::format(" {}", child.node);
        } else {
            text += "      " + child_text(visit, child) + "\n";
            if (child.tested) {
                text += "        " + leaf_text(*child.tested, visit.minimum) + "\n";
            }
        }
    }
    if (!missed.empty()) text += "      missed " + missed + "\n";
}

void tell(std::string& text, const TraversalHistory& traversal) {
    for (const std::string& gap : traversal.gaps) text += "    not captured: " + gap + "\n";
    for (const Visit& visit : traversal.visits) tell(text, visit);
    for (const GatheredHit& hit : traversal.stray) {
        text += fmt::format("    buffered {} in slot {}, from no leaf that the ray was in\n",
                            hit_text(hit.hit), hit.slot);
    }
    if (!traversal.merged) {
        text += "    the merge was not captured\n";
    } else if (!is_hit(*traversal.merged)) {
        text += "    merged: nothing is hit\n";
    } else {
        text += fmt::format("    merged: {}", exact(*traversal.merged));
        text += traversal.winner_node == kNone
                    ? ", which no leaf of the ray buffered\n"
                    : fmt::format(", from node {}\n", traversal.winner_node);
    }
}

void tell(std::string& text, const LightHistory& light, std::uint32_t bounce) {
    text += fmt::format("  bounce{}/light{}: ", bounce, light.light);
    if (light.shadow_ray && is_dead(*light.shadow_ray)) {
        text += "no light to ask for\n";
        return;
    }
    text += light.shadow_ray ? "shadow ray " + exact(*light.shadow_ray) : "not captured";
    if (light.potential) text += ", worth " + exact(*light.potential);
    text += "\n";
    tell(text, light.traversal);
    if (light.traversal.merged) {
        text +=
            is_hit(*light.traversal.merged) ? "    the light is hidden" : "    the light is free";
        if (light.radiance) text += ": the path has " + exact(*light.radiance);
        text += "\n";
    }
}

void tell(std::string& text, const BounceHistory& bounce) {
    text += fmt::format("  bounce{}: {}\n", bounce.bounce,
                        bounce.traversal.ray ? exact(*bounce.traversal.ray) : "not captured");
    tell(text, bounce.traversal);
    for (const LightHistory& light : bounce.lights) tell(text, light, bounce.bounce);
    if (!bounce.flags) return;
    const bool specular = (*bounce.flags & reference::kPathSpecular) != 0;
    if (is_alive(bounce.next)) {
        text += fmt::format("  scattered{} to {}", specular ? " (mirror or glass)" : "",
                            exact(*bounce.next));
        if (bounce.throughput) text += ", throughput " + exact(*bounce.throughput);
    } else {
        text += "  the path ended";
    }
    if (bounce.radiance) text += ", radiance " + exact(*bounce.radiance);
    text += "\n";
}

/// A ray that is dead and went nowhere has no story.
bool happened(const TraversalHistory& traversal) {
    return is_alive(traversal.ray) || traversal.visits.size() > 1 || !traversal.stray.empty();
}

std::string outcome_text(const std::optional<Visit>& visit) {
    if (!visit) return "-";
    if (visit->leaf) return leaf_text(*visit, visit->minimum);
    std::string text;
    for (const ChildVisit& child : visit->children) {
        if (child.outcome == Outcome::missed) continue;
        text +=
            fmt::format("{}{} {}", text.empty() ? "" : "; ", to_string(child.outcome), child.node);
    }
    return text.empty() ? "missed all children" : text;
}

template <class Act>
void for_each_traversal(const RayHistory& history, const Act& act) {
    for (const BounceHistory& bounce : history.bounces) {
        act(bounce.traversal);
        for (const LightHistory& light : bounce.lights) act(light.traversal);
    }
}

}  // namespace

std::string to_text(const RayHistory& history) {
    std::string text = fmt::format("ray {} of batch {}", history.ray, history.batch);
    if (history.from) {
        text += fmt::format(": pixel ({}, {}), sample {}", history.from->pixel_x,
                            history.from->pixel_y, history.from->sample);
    }
    text += "\n";
    if (history.minimum_is_later) {
        text += "  early-out immediate: minima are those that each launch left behind\n";
    }
    for (const BounceHistory& bounce : history.bounces) {
        if (happened(bounce.traversal) || !bounce.traversal.ray) tell(text, bounce);
    }
    if (history.radiance) text += "  the path's radiance: " + exact(*history.radiance) + "\n";
    if (history.pixel) text += "  the pixel: " + exact(*history.pixel) + "\n";
    return text;
}

Table history_table(const std::string& title, const RayHistory& history) {
    Table table{title,
                {"ray", "traversal", "launch", "level", "node", "position", "block", "thread",
                 "minimum", "outcome", "target", "distance"},
                {}};
    for_each_traversal(history, [&](const TraversalHistory& traversal) {
        for (const Visit& v : traversal.visits) {
            const auto row = [&](const char* outcome, std::uint32_t target,
                                 const std::optional<float>& distance) {
                table.rows.push_back({history.ray, traversal.name, v.launch, v.level, v.node,
                                      v.position, v.block, v.thread, json_number(v.minimum),
                                      outcome,
                                      target == kNone ? ordered_json() : ordered_json(target),
                                      json_number(distance)});
            };
            const auto leaf_rows = [&](const LeafVisit& leaf) {
                const char* outcome = to_string(leaf.leaf_outcome);
                if (leaf.hits.empty()) row(outcome, leaf.closest.primitive, leaf.closest.t);
                for (const GatheredHit& hit : leaf.hits) {
                    row(hit.won ? "won" : outcome, hit.hit.primitive, hit.hit.t);
                }
            };
            for (const ChildVisit& child : v.children) {
                row(to_string(child.outcome), child.node, child.entry);
                if (child.tested) leaf_rows(*child.tested);
            }
            if (v.leaf) leaf_rows(v);
        }
    });
    return table;
}

Table history_table(const std::string& title, const RayHistory& a, const RayHistory& b) {
    Table table{
        title,
        {"ray", "traversal", "level", "node", "change", "what", "entry_a", "entry_b", "a", "b"},
        {}};
    for (const TraversalPair& traversal : align(a, b)) {
        for (const VisitPair& pair : traversal.visits) {
            const Visit& visit = pair.a ? *pair.a : *pair.b;
            const auto entry = [](const std::optional<Visit>& side) {
                return side ? ordered_json(side->position) : ordered_json();
            };
            table.rows.push_back({a.ray, traversal.name, visit.level, visit.node,
                                  to_string(pair.change), "visit", entry(pair.a), entry(pair.b),
                                  outcome_text(pair.a), outcome_text(pair.b)});
            for (const PartPair& part : pair.parts) {
                table.rows.push_back({a.ray, traversal.name, visit.level, visit.node,
                                      to_string(part.change), part.what, nullptr, nullptr,
                                      part.a.empty() ? "-" : part.a,
                                      part.b.empty() ? "-" : part.b});
            }
        }
    }
    return table;
}

}  // namespace scotty::verify
