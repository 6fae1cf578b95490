/// How both pipelines publish what they do: one call per kernel launch, with named buffers.
///
/// A stage is one kernel launch seen as a function from input buffers to output buffers. Its name
/// is a path such as "bounce1/light0/level3/intersect". With no observer attached nothing is copied
/// or computed for it; capture, invariants, debugger and timeline are all observers.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "reference/base/error.h"
#include "reference/contract/records.h"
#include "reference/contract/stages.h"

namespace scotty::reference {

/// A buffer as it lies in memory. Records are shown as their fields: Ray is float32 [n, 8],
/// Hit is uint32 [n, 4] (t, u and v as bits), Vec3 is float32 [n, 3].
struct BufferView {
    std::string_view name;
    ElementType type = ElementType::uint32;
    std::vector<std::size_t> shape;
    const void* data = nullptr;
    std::string_view meaning;
    std::size_t bytes = 0;
};

constexpr std::uint32_t kNotApplicable = 0xffffffffu;

struct StageView {
    std::string name;
    StageKind kind = StageKind::primary_rays;
    std::uint32_t launch = 0;  ///< counts launches of one render, from 0
    std::uint32_t batch = 0;
    std::uint32_t bounce = kNotApplicable;
    std::uint32_t light = kNotApplicable;
    std::uint32_t level = kNotApplicable;
    std::uint32_t blocks = 0;
    std::uint32_t threads = 0;  ///< a block
    std::vector<BufferView> inputs;
    std::vector<BufferView> outputs;

    /// Null where there is no such buffer.
    const BufferView* find(std::string_view buffer) const;

    /// Typed view of an input or output; empty where the stage has no such buffer.
    /// Throws internal when sizeof(T) does not divide the buffer.
    template <class T>
    std::span<const T> get(const Buffer<T>& buffer) const {
        return get<T>(buffer.name);
    }
    template <class T>
    std::span<const T> get(std::string_view buffer) const {
        static_assert(std::is_trivially_copyable_v<T>);
        const BufferView* view = find(buffer);
        if (view == nullptr || view->bytes == 0) return {};
        if (view->bytes % sizeof(T) != 0) {
            throw Error::internal("buffer " + std::string(buffer) + " of " + name +
                                  " read as another type");
        }
        return {static_cast<const T*>(view->data), view->bytes / sizeof(T)};
    }
};

class StageObserver {
 public:
    StageObserver() = default;
    StageObserver(const StageObserver&) = delete;
    StageObserver& operator=(const StageObserver&) = delete;
    virtual ~StageObserver() = default;

    /// False: the stage is not shown, which saves preparing it.
    virtual bool wants(StageKind) const { return true; }
    /// False: the pipeline may take the way that it takes with no observer attached. It need not
    /// wait for every launch, and what has no launch of its own on that way is not shown.
    virtual bool follows_launches() const { return true; }
    /// Before each batch of a render, when `done` of `count` are complete, and after the last.
    /// May throw, which ends the render. A render that ran out of memory begins again at 0.
    virtual void on_batch(std::uint64_t /*done*/, std::uint64_t /*count*/) {}
    /// After the launch. The views are valid during the call only.
    virtual void on_stage(const StageView& stage) = 0;
    /// Before a traversal is run again because a buffer had to grow ("grown and retried"): what was
    /// shown of this traversal since its first level does not count.
    virtual void on_retry(std::string_view /*stage*/, std::string_view /*reason*/) {}
};

/// The name of a stage from its place.
std::string stage_name(StageKind kind, std::uint32_t batch, std::uint32_t bounce,
                       std::uint32_t light, std::uint32_t level, bool several_batches);

template <class T>
BufferView buffer_view(std::string_view name, std::span<const T> data, std::string_view meaning) {
    BufferView view{name,    element_type_of<T>(), {data.size()}, data.data(),
                    meaning, data.size_bytes()};
    constexpr std::size_t words = sizeof(T) / (element_type_of<T>() == ElementType::uint64 ? 8 : 4);
    if (words > 1) view.shape.push_back(words);
    return view;
}
/// The buffer over `data`, which it borrows. Of a hit list `rows` says how many rays share the
/// slots.
template <class T>
BufferView buffer_view(const Buffer<T>& buffer, std::type_identity_t<std::span<const T>> data,
                       std::size_t rows = 0) {
    BufferView view = buffer_view<T>(buffer.name, data, buffer.meaning);
    if (rows != 0) view.shape = {rows, data.size() / rows, buffer.fields.size()};
    return view;
}

}  // namespace scotty::reference
