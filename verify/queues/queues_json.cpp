#include "verify/queues/queues_json.h"

#include <nlohmann/json.hpp>

#include "verify/base/json_number.h"

namespace scotty::verify {

using nlohmann::ordered_json;
using reference::kNone;
using reference::kNotApplicable;

namespace {

ordered_json id(std::uint32_t value) {
    return value == kNone ? ordered_json() : ordered_json(value);
}

template <class T>
ordered_json id(const std::optional<T>& value) {
    return value ? ordered_json(*value) : ordered_json();
}

ordered_json document(const reference::Vec3& v) {
    return {json_number(v.x), json_number(v.y), json_number(v.z)};
}

ordered_json document(const reference::Ray& ray) {
    return {{"origin", document(ray.origin)},
            {"direction", document(ray.direction)},
            {"t_min", json_number(ray.t_min)},
            {"t_max", json_number(ray.t_max)}};
}

ordered_json document(const reference::Hit& hit) {
    return {{"t", json_number(hit.t)},
            {"primitive", id(hit.primitive)},
            {"u", json_number(hit.u)},
            {"v", json_number(hit.v)}};
}

template <class T>
ordered_json maybe(const std::optional<T>& value) {
    return value ? document(*value) : ordered_json();
}

ordered_json document(const GatheredHit& hit) {
    return {{"slot", hit.slot},
            {"t", json_number(hit.hit.t)},
            {"primitive", id(hit.hit.primitive)},
            {"won", hit.won}};
}

ordered_json document(const ChildVisit& child);
ordered_json document(const Visit& visit);
ordered_json document(const LightHistory& light);
ordered_json document(const BounceHistory& bounce);

template <class T>
ordered_json list(const std::vector<T>& items) {
    ordered_json out = ordered_json::array();
    for (const T& item : items) out.push_back(document(item));
    return out;
}

ordered_json document(const LeafVisit& leaf) {
    return {{"outcome", to_string(leaf.leaf_outcome)},
            {"closest", leaf.closest.primitive == kNone
                            ? ordered_json()
                            : ordered_json{{"t", json_number(leaf.closest.t)},
                                           {"primitive", leaf.closest.primitive}}},
            {"hits", list(leaf.hits)}};
}

ordered_json document(const ChildVisit& child) {
    ordered_json out{{"node", child.node},
                     {"outcome", to_string(child.outcome)},
                     {"entry", json_number(child.entry)},
                     {"position", id(child.position)},
                     {"times", child.times}};
    if (child.tested) out["leaf"] = document(*child.tested);
    return out;
}

ordered_json document(const Visit& visit) {
    ordered_json out{{"launch", visit.launch},     {"stage", visit.stage},
                     {"level", visit.level},       {"node", visit.node},
                     {"position", visit.position}, {"block", visit.block},
                     {"thread", visit.thread},     {"minimum", json_number(visit.minimum)}};
    if (visit.subtree) out["subtree"] = true;
    if (visit.leaf) {
        out["leaf"] = document(static_cast<const LeafVisit&>(visit));
    } else {
        out["children"] = list(visit.children);
    }
    return out;
}

ordered_json document(const TraversalHistory& traversal) {
    return {{"name", traversal.name},
            {"ray", maybe(traversal.ray)},
            {"gaps", traversal.gaps},
            {"visits", list(traversal.visits)},
            {"stray", list(traversal.stray)},
            {"merge_launch", id(traversal.merge_launch)},
            {"merged", maybe(traversal.merged)},
            {"winner_node", id(traversal.winner_node)}};
}

ordered_json document(const LightHistory& light) {
    return {{"light", light.light},
            {"shadow_ray", maybe(light.shadow_ray)},
            {"potential", maybe(light.potential)},
            {"traversal", document(light.traversal)},
            {"radiance", maybe(light.radiance)}};
}

ordered_json document(const BounceHistory& bounce) {
    return {{"bounce", bounce.bounce},           {"traversal", document(bounce.traversal)},
            {"lights", list(bounce.lights)},     {"flags", id(bounce.flags)},
            {"next", maybe(bounce.next)},        {"throughput", maybe(bounce.throughput)},
            {"radiance", maybe(bounce.radiance)}};
}

}  // namespace

ordered_json to_json(const RayHistory& history) {
    ordered_json out{{"batch", history.batch}, {"ray", history.ray}};
    out["pixel"] =
        history.from ? ordered_json{history.from->pixel_x, history.from->pixel_y} : ordered_json();
    out["sample"] = history.from ? ordered_json(history.from->sample) : ordered_json();
    out["minimum_is_later"] = history.minimum_is_later;
    out["bounces"] = list(history.bounces);
    out["radiance"] = maybe(history.radiance);
    out["pixel_value"] = maybe(history.pixel);
    return out;
}

ordered_json to_json(const RayHistory& a, const RayHistory& b) {
    ordered_json differences = ordered_json::array();
    for (const TraversalPair& traversal : align(a, b)) {
        for (const VisitPair& visit : traversal.visits) {
            if (visit.change == Change::same) continue;
            const Visit& shown = visit.a ? *visit.a : *visit.b;
            ordered_json what = ordered_json::array();
            for (const PartPair& part : visit.parts) {
                what.push_back({{"what", part.what},
                                {"change", to_string(part.change)},
                                {"a", part.a},
                                {"b", part.b}});
            }
            differences.push_back({{"traversal", traversal.name},
                                   {"level", shown.level},
                                   {"node", shown.node},
                                   {"change", to_string(visit.change)},
                                   {"what", std::move(what)}});
        }
    }
    return {{"batch", a.batch},
            {"ray", a.ray},
            {"a", to_json(a)},
            {"b", to_json(b)},
            {"differences", std::move(differences)}};
}

}  // namespace scotty::verify
