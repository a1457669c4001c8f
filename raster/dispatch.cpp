// Compute: workgroups in chunks over the pool.
#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "base/stop_word.h"
#include "raster/raster.h"

namespace pineda::raster {
namespace {

constexpr uint32_t kGroupsPerCall = 64;             // PrimRecords given to the kernel at once
constexpr uint32_t kSharedBytesPerCall = 16 << 10;  // their shared memory should stay in L1
constexpr uint64_t kInvocationsPerChunk = 2048;     // below this a hand-over costs more than the work of a simple kernel
constexpr uint32_t kChunksPerThread = 16;           // for balance
constexpr size_t kAlignmentBytes = 64;

// Memory of one thread during one dispatch.
struct GroupScratch {
  WorkgroupRecord groups[kGroupsPerCall];
  PrimRecord prims[kGroupsPerCall];
  std::unique_ptr<uint8_t[]> shared_storage, frame_storage;
  uint8_t* shared = nullptr;  // null when nothing is shared
  uint8_t* frames = nullptr;

  GroupScratch(size_t shared_bytes, size_t frame_bytes) {
    if (shared_bytes != 0) shared = allocate(shared_storage, shared_bytes);
    if (frame_bytes != 0) frames = allocate(frame_storage, frame_bytes);
  }

 private:
  // Not cleared: a kernel stores to its frames before it reads them.
  static uint8_t* allocate(std::unique_ptr<uint8_t[]>& storage, size_t bytes) {
    storage = std::make_unique_for_overwrite<uint8_t[]>(bytes + kAlignmentBytes);
    const auto address = reinterpret_cast<uintptr_t>(storage.get());
    return storage.get() + (kAlignmentBytes - address % kAlignmentBytes) % kAlignmentBytes;
  }
};

std::vector<ComputeWave> make_waves(uint64_t invocations) {
  std::vector<ComputeWave> waves((invocations + kLanes - 1) / kLanes);
  for (size_t i = 0; i < waves.size(); ++i) {
    const uint64_t left = invocations - i * kLanes;
    waves[i] = {left >= kLanes ? 0xFFFFu : (1u << left) - 1, static_cast<uint32_t>(i * kLanes)};
  }
  return waves;
}

class Dispatcher {
 public:
  Dispatcher(ThreadPool& pool, const DispatchPacket& packet)
      : packet_(packet),
        invocations_(uint64_t{packet.local_size[0]} * packet.local_size[1] * packet.local_size[2]),
        waves_(make_waves(invocations_)),
        shared_stride_((packet.shared_memory_bytes + kAlignmentBytes - 1) / kAlignmentBytes * kAlignmentBytes),
        groups_per_call_(packet.shared_memory_bytes == 0 ? kGroupsPerCall
                                                         : static_cast<uint32_t>(std::clamp<size_t>(
                                                               kSharedBytesPerCall / shared_stride_, 1, kGroupsPerCall))),
        scratch_(pool.threads()) {}

  // Workgroups [first, end) in x-fastest order.
  void run(uint64_t first, uint64_t end, uint32_t thread) {
    if (!scratch_[thread]) {
      scratch_[thread] =
          std::make_unique<GroupScratch>(shared_stride_ * groups_per_call_, packet_.wave_frame_bytes * waves_.size());
    }
    GroupScratch& scratch = *scratch_[thread];
    ThreadContext context{};
    context.wave_frames = scratch.frames;
    while (first < end && !kernels_stopped()) {
      const auto n = static_cast<uint32_t>(std::min<uint64_t>(end - first, groups_per_call_));
      // Zeroed for every workgroup: what an earlier one left behind would depend on the number of threads.
      if (scratch.shared) std::memset(scratch.shared, 0, shared_stride_ * n);
      for (uint32_t i = 0; i < n; ++i) {
        const uint64_t index = first + i;
        const uint64_t row = index / packet_.count[0];
        WorkgroupRecord& group = scratch.groups[i];
        group.id[0] = packet_.base[0] + static_cast<uint32_t>(index % packet_.count[0]);
        group.id[1] = packet_.base[1] + static_cast<uint32_t>(row % packet_.count[1]);
        group.id[2] = packet_.base[2] + static_cast<uint32_t>(row / packet_.count[1]);
        group.reserved = 0;
        group.shared_memory = scratch.shared ? scratch.shared + shared_stride_ * i : nullptr;
        scratch.prims[i] = {&group, 0, static_cast<uint32_t>(waves_.size())};
      }
      packet_.kernel(packet_.context, &context, scratch.prims, n, waves_.data());
      first += n;
    }
  }

  uint64_t invocations() const { return invocations_; }

 private:
  const DispatchPacket& packet_;
  const uint64_t invocations_;
  const std::vector<ComputeWave> waves_;
  const size_t shared_stride_;
  const uint32_t groups_per_call_;
  std::vector<std::unique_ptr<GroupScratch>> scratch_;
};

}  // namespace

void dispatch(ThreadPool& pool, const DispatchPacket& packet) {
  const uint64_t groups = uint64_t{packet.count[0]} * packet.count[1] * packet.count[2];
  if (groups == 0) return;
  Dispatcher dispatcher(pool, packet);
  if (dispatcher.invocations() == 0) return;
  const uint64_t target_chunks = uint64_t{pool.threads()} * kChunksPerThread;
  const uint64_t smallest = std::max<uint64_t>(1, kInvocationsPerChunk / dispatcher.invocations());
  const uint64_t chunk = std::max((groups + target_chunks - 1) / target_chunks, smallest);
  const auto chunks = static_cast<uint32_t>((groups + chunk - 1) / chunk);
  pool.parallel_for(chunks,
                    [&](uint32_t i, uint32_t thread) { dispatcher.run(i * chunk, std::min(groups, (i + 1) * chunk), thread); });
}

}  // namespace pineda::raster
