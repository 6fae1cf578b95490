#include <cstdio>
#include <random>

#include "gpu/host/cuda_error.h"
#include "gpu/host/device_memory.h"
#include "gpu/host/pipeline.h"
#include "gpu/kernels/dialect.h"
#include "gpu/parity/parity.h"
#include "gpu/parity/parity_functions.h"

namespace scotty::gpu {

using namespace SCOTTY_DEVICE_NAMESPACE;

namespace {

SCOTTY_KERNEL(run_parity_case)
(ParityCase which, std::uint32_t count, const ParityOperands* operands, ParityWords* results) {
    const std::uint32_t i = block_index() * block_size() + thread_index();
    if (i < count) results[i] = parity_case(which, operands[i]);
}

constexpr std::uint32_t kSpecial[] = {0x00000000, 0x80000000, 0x00000001, 0x80000001, 0x007fffff,
                                      0x00800000, 0x00800001, 0x3f800000, 0xbf800000, 0x3f7fffff,
                                      0x3f800001, 0x7f7fffff, 0xff7fffff, 0x7f800000, 0xff800000,
                                      0x7fc00000, 0x34000000, 0x5f000000, 0x1f000000, 0x40490fdb};

float operand(std::mt19937_64& random) {
    const std::uint64_t bits = random();
    float value = 0.0f;
    std::uint32_t word = static_cast<std::uint32_t>(bits >> 32);
    switch (bits & 7) {
        case 0:
            word = kSpecial[word % (sizeof(kSpecial) / sizeof(kSpecial[0]))];
            break;
        case 1:
            break;  // any bits
        default:
            return static_cast<float>(static_cast<std::int32_t>(word)) * 0x1p-30f;  // [-2, 2)
    }
    std::memcpy(&value, &word, sizeof(value));
    return value;
}

std::string describe(const ParityOperands& operands, const ParityWords& host,
                     const ParityWords& device) {
    std::string text = "operands";
    char hex[16];
    for (const float x : operands.x) {
        std::snprintf(hex, sizeof(hex), " %08x", parity_bits(x));
        text += hex;
    }
    for (const auto& [label, words] : {std::pair{" host", &host}, std::pair{" device", &device}}) {
        text += label;
        for (const std::uint32_t word : words->word) {
            std::snprintf(hex, sizeof(hex), " %08x", word);
            text += hex;
        }
    }
    return text;
}

}  // namespace

std::vector<ParityResult> test_parity(std::uint64_t count) {
    if (!find_device()) throw reference::Error::missing_environment("no CUDA device");
    constexpr std::uint32_t kChunk = 1u << 18;
    MemoryBudget budget;
    DeviceMemory<ParityOperands> device_operands(budget);
    DeviceMemory<ParityWords> device_results(budget);
    device_results.resize(kChunk, "results");
    std::vector<ParityOperands> operands(kChunk);
    std::vector<ParityResult> results;
    for (std::uint32_t which = 0; which < static_cast<std::uint32_t>(ParityCase::count); ++which) {
        ParityResult result{kParityNames[which], 0, 0, ""};
        std::mt19937_64 random(which + 1);
        while (result.tried < count) {
            for (ParityOperands& set : operands) {
                for (float& x : set.x) x = operand(random);
            }
            device_operands.upload(operands, "operands");
            SCOTTY_LAUNCH(run_parity_case, kChunk / 256, 256, nullptr,
                          static_cast<ParityCase>(which), kChunk, device_operands.data(),
                          device_results.data());
            check(cudaGetLastError(), result.name);
            const auto device = download(device_results.data(), kChunk, "results");
            for (std::uint32_t i = 0; i < kChunk; ++i) {
                const ParityWords host = parity_case(static_cast<ParityCase>(which), operands[i]);
                if (std::memcmp(&host, &device[i], sizeof(host)) == 0) continue;
                if (result.mismatches++ == 0) {
                    result.first = describe(operands[i], host, device[i]);
                }
            }
            result.tried += kChunk;
        }
        results.push_back(result);
    }
    return results;
}

}  // namespace scotty::gpu
