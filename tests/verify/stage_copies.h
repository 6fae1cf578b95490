/// A run's stages with buffers of their own, to be spoiled and shown to a checker.
#pragma once

#include <algorithm>
#include <cstring>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "reference/contract/stage_observer.h"
#include "tests/catch.h"

namespace scotty::verify::test {

/// One stage; `view` points into `bytes`. Buffers are found by name, inputs apart from outputs.
struct StageCopy {
    reference::StageView view;
    std::deque<std::string> names;
    std::deque<std::vector<std::byte>> bytes;

    template <class T>
    std::span<T> input(std::string_view name) {
        return writable<T>(view.inputs, name);
    }
    template <class T>
    std::span<T> output(std::string_view name) {
        return writable<T>(view.outputs, name);
    }

 private:
    template <class T>
    std::span<T> writable(std::vector<reference::BufferView>& buffers, std::string_view name) {
        for (auto& buffer : buffers) {
            if (buffer.name == name) {
                return {static_cast<T*>(const_cast<void*>(buffer.data)), buffer.bytes / sizeof(T)};
            }
        }
        FAIL("stage " << view.name << " has no buffer " << name);
        return {};
    }
};

/// Copies every stage of a run (kinds that `only` names, or all).
class StageCopies : public reference::StageObserver {
 public:
    void on_stage(const reference::StageView& stage) override {
        StageCopy& copy = stages_.emplace_back();
        copy.view = stage;
        for (auto* buffers : {&copy.view.inputs, &copy.view.outputs}) {
            for (reference::BufferView& buffer : *buffers) {
                const auto* first = static_cast<const std::byte*>(buffer.data);
                buffer.name = copy.names.emplace_back(buffer.name);
                buffer.meaning = {};
                buffer.data = copy.bytes.emplace_back(first, first + buffer.bytes).data();
            }
        }
    }

    /// The stage of that name; its last copy where a traversal was run again.
    StageCopy& at(std::string_view name) {
        const auto stage =
            std::find_if(stages_.rbegin(), stages_.rend(),
                         [&](const StageCopy& copy) { return copy.view.name == name; });
        if (stage == stages_.rend()) FAIL("no stage " << name);
        return *stage;
    }

    void show_to(reference::StageObserver& observer) const {
        for (const StageCopy& stage : stages_) observer.on_stage(stage.view);
    }

    std::deque<StageCopy>& all() { return stages_; }

 private:
    std::deque<StageCopy> stages_;
};

}  // namespace scotty::verify::test
