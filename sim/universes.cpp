#include "sim/universes.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>

#include "sim/core/check.h"

// The sequence lock, without fences so that ThreadSanitizer can follow it.
//
// The writer makes the lock odd, stores the data with release, makes the lock even with release. The reader loads the
// lock with acquire, the data with acquire, the lock again. Two facts make this correct:
// - The first load returns the even value of write k: all of write k happened before it, so no data is older than k.
// - If some data comes from write k+1, its release store follows the odd value of k+1. So the second load of the lock
//   returns that odd value or a later one, and the reader discards the copy.

namespace footlight {
namespace {

static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

// A write takes tens of nanoseconds. After this many spins the reader assumes that it shares a core with a stopped
// writer.
constexpr int kSpinsBeforeSleep = 1000;
constexpr auto kSleepBetweenTries = std::chrono::microseconds(50);

}  // namespace

std::vector<Universe> universe_range(Universe first, int count) {
  std::vector<Universe> numbers;
  numbers.reserve(static_cast<std::size_t>(std::max(count, 0)));
  for (int i = 0; i < count; ++i) numbers.push_back(first + i);
  return numbers;
}

Universes::Universes() : Universes(universe_range(kUniverseMin, kUniverseCountDefault)) {}

Universes::Universes(std::span<const Universe> numbers) : numbers_(numbers.begin(), numbers.end()) {
  std::sort(numbers_.begin(), numbers_.end());
  numbers_.erase(std::unique(numbers_.begin(), numbers_.end()), numbers_.end());
  FL_CHECK(!numbers_.empty());
  FL_CHECK_GE(numbers_.front(), kUniverseMin);
  FL_CHECK_LE(numbers_.back(), kUniverseMax);
  heads_ = std::make_unique<Head[]>(numbers_.size());
  words_ = std::make_unique<std::atomic<std::uint64_t>[]>(numbers_.size() * kWordsPerUniverse);
}

Result<std::unique_ptr<Universes>> Universes::make(std::span<const Universe> numbers) {
  if (numbers.empty()) return fail(ErrorCode::kBadInput, "no universe is named; expected at least one from 1 to 63999");
  for (Universe number : numbers)
    if (!is_universe(number))
      return fail(ErrorCode::kBadInput, "universe {}: expected a number from {} to {}", number, kUniverseMin,
                  kUniverseMax);
  return std::make_unique<Universes>(numbers);
}

int Universes::index_of(Universe universe) const {
  const int guess = universe - numbers_.front();  // correct if the numbers are consecutive
  if (guess < 0 || universe > numbers_.back()) return -1;
  if (guess < count() && numbers_[static_cast<std::size_t>(guess)] == universe) return guess;
  const auto found = std::lower_bound(numbers_.begin(), numbers_.end(), universe);
  return *found == universe ? static_cast<int>(found - numbers_.begin()) : -1;
}

void Universes::write(int index, const FrameView& frame) {
  FL_CHECK(index >= 0 && index < count());
  FL_CHECK_LE(frame.slots.size(), static_cast<std::size_t>(kSlotCountMax));
  Head& head = heads_[static_cast<std::size_t>(index)];
  std::atomic<std::uint64_t>* const words = words_.get() + static_cast<std::size_t>(index) * kWordsPerUniverse;

  // The only writer reads its own last values.
  const std::uint64_t lock = head.lock.load(std::memory_order_relaxed);
  const std::uint32_t revision = head.revision.load(std::memory_order_relaxed) + 1;
  head.lock.store(lock + 1, std::memory_order_relaxed);

  const std::size_t whole_words = frame.slots.size() / 8;
  const std::size_t rest_bytes = frame.slots.size() % 8;
  const std::uint8_t* from = frame.slots.data();
  for (std::size_t i = 0; i < whole_words; ++i, from += 8) {
    std::uint64_t word;
    std::memcpy(&word, from, 8);
    words[i].store(word, std::memory_order_release);
  }
  if (rest_bytes != 0) {
    std::uint64_t word = words[whole_words].load(std::memory_order_relaxed);
    std::memcpy(&word, from, rest_bytes);
    words[whole_words].store(word, std::memory_order_release);
  }
  head.stamp_ns.store(frame.stamp_ns, std::memory_order_release);
  head.sender.store(frame.sender, std::memory_order_release);
  head.sequence.store(frame.sequence, std::memory_order_release);
  head.revision.store(revision == 0 ? 1 : revision, std::memory_order_release);  // 0 means "never written"

  head.lock.store(lock + 2, std::memory_order_release);
  revision_.fetch_add(1, std::memory_order_release);
}

void Universes::read(int index, std::uint8_t* levels, FrameStamp& stamp) const {
  const Head& head = heads_[static_cast<std::size_t>(index)];
  const std::atomic<std::uint64_t>* const words = words_.get() + static_cast<std::size_t>(index) * kWordsPerUniverse;
  for (int tries = 1;; ++tries) {
    const std::uint64_t lock = head.lock.load(std::memory_order_acquire);
    if ((lock & 1) == 0) {
      for (std::size_t i = 0; i < kWordsPerUniverse; ++i) {
        const std::uint64_t word = words[i].load(std::memory_order_acquire);
        std::memcpy(levels + i * 8, &word, 8);
      }
      stamp.stamp_ns = head.stamp_ns.load(std::memory_order_acquire);
      stamp.sender = head.sender.load(std::memory_order_acquire);
      stamp.sequence = head.sequence.load(std::memory_order_acquire);
      stamp.revision = head.revision.load(std::memory_order_acquire);
      if (head.lock.load(std::memory_order_relaxed) == lock) return;
    }
    if (tries % kSpinsBeforeSleep == 0) std::this_thread::sleep_for(kSleepBetweenTries);
  }
}

void Universes::snapshot(int index, std::span<std::uint8_t, kSlotCountMax> levels, FrameStamp& stamp) const {
  FL_CHECK(index >= 0 && index < count());
  read(index, levels.data(), stamp);
}

void Universes::snapshot_all(std::span<std::uint8_t> levels, std::span<FrameStamp> stamps) const {
  FL_CHECK_EQ(levels.size(), numbers_.size() * kSlotCountMax);
  FL_CHECK_EQ(stamps.size(), numbers_.size());
  for (std::size_t i = 0; i < numbers_.size(); ++i)
    read(static_cast<int>(i), levels.data() + i * kSlotCountMax, stamps[i]);
}

int Universes::snapshot_changed(std::span<std::uint8_t> levels, std::span<FrameStamp> stamps) const {
  FL_CHECK_EQ(levels.size(), numbers_.size() * kSlotCountMax);
  FL_CHECK_EQ(stamps.size(), numbers_.size());
  int changed_count = 0;
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    // Equal revisions: no write finished since. The next call finds a write in progress.
    if (heads_[i].revision.load(std::memory_order_acquire) == stamps[i].revision) continue;
    read(static_cast<int>(i), levels.data() + i * kSlotCountMax, stamps[i]);
    ++changed_count;
  }
  return changed_count;
}

}  // namespace footlight
