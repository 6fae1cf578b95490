/// Buffers of a stage that is run alone: checked inputs, and outputs by name.
#pragma once

#include <fmt/format.h>

#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reference/error.h"
#include "reference/owned_buffer.h"
#include "reference/stage_observer.h"

namespace scotty::emulation {

class ReplayBuffers {
 public:
    explicit ReplayBuffers(const reference::StageView& stage) : stage_(stage) {}

    [[noreturn]] void fail(std::string_view buffer, const std::string& what) const {
        throw reference::Error::bad_input(fmt::format("{}: {}", stage_.name, buffer), what);
    }

    bool has(std::string_view name) const { return find(name) != nullptr; }

    /// An input; throws where it is missing.
    template <class T>
    std::span<const T> input(std::string_view name) const {
        const reference::BufferView* view = find(name);
        if (view == nullptr) fail(name, "the stage needs it to be run alone, and it is missing");
        if (view->bytes % sizeof(T) != 0) {
            fail(name, fmt::format("expected elements of {} bytes, found {} bytes", sizeof(T),
                                   view->bytes));
        }
        return {static_cast<const T*>(view->data), view->bytes / sizeof(T)};
    }
    /// The same; throws unless it has `count` elements.
    template <class T>
    std::span<const T> input(std::string_view name, std::size_t count) const {
        const std::span<const T> values = input<T>(name);
        if (values.size() != count) {
            fail(name, fmt::format("expected {} elements, found {}", count, values.size()));
        }
        return values;
    }
    /// A copy to work on.
    template <class T>
    std::vector<T> copy(std::string_view name, std::size_t count) const {
        const std::span<const T> values = input<T>(name, count);
        return {values.begin(), values.end()};
    }

    template <class T>
    void output(std::string_view name, const std::vector<T>& values, std::string_view meaning) {
        outputs_.push_back(own(reference::buffer_view(name, std::span<const T>(values), meaning)));
    }
    void shape_last(std::vector<std::size_t> shape) { outputs_.back().shape = std::move(shape); }

    std::vector<reference::OwnedBuffer> take() && { return std::move(outputs_); }

 private:
    const reference::BufferView* find(std::string_view name) const {
        for (const reference::BufferView& view : stage_.inputs) {
            if (view.name == name) return &view;
        }
        return nullptr;
    }

    const reference::StageView& stage_;
    std::vector<reference::OwnedBuffer> outputs_;
};

}  // namespace scotty::emulation
