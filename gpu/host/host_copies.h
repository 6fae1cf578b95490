/// Host copies of device buffers, for observers.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "gpu/host/device_memory.h"
#include "gpu/kernels/dialect.h"
#include "reference/contract/stage_observer.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// Views stay valid as long as this lives.
class HostCopies {
 public:
    template <class T>
    reference::BufferView view(const reference::Buffer<T>& of, std::vector<T> values,
                               std::size_t rows = 0) {
        auto host = std::make_shared<std::vector<T>>(std::move(values));
        kept_.push_back(host);
        return reference::buffer_view(of, std::span<const T>(*host), rows);
    }
    /// Of a hit list `rows` says how many rays share the slots.
    template <class T>
    reference::BufferView view(const reference::Buffer<T>& of, const T* device, std::size_t count,
                               std::size_t rows = 0) {
        return view(of, download(device, count, of.name.data()), rows);
    }

 private:
    std::vector<std::shared_ptr<void>> kept_;
};

}  // namespace SCOTTY_DEVICE_NAMESPACE
