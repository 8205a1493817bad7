#include "render/vk/specialised.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "render/vk/spirv_words.h"

namespace footlight::render::vk {
namespace {

constexpr std::uint32_t kIdsMax = 1u << 20;  // a shader of the frame has up to 20,000
// Of GLSL.std.450: those that write through a pointer.
constexpr std::uint32_t kModf = 35;
constexpr std::uint32_t kFrexp = 51;

struct Instruction {
  std::uint32_t op = 0;
  std::span<const std::uint32_t> words;  // behind the first one: of a value its type, its id, its operands
};

// What is known of the value of an id at every moment that it has one.
struct Known {
  enum State : std::uint8_t { kNothingYet, kConstant, kVaries } state = kNothingYet;
  std::uint32_t value = 0;  // of a constant; booleans: 0 or 1
  bool operator==(const Known&) const = default;
};
constexpr Known kVarying{Known::kVaries, 0};
constexpr Known constant(std::uint32_t value) { return {Known::kConstant, value}; }

struct Block {
  std::uint32_t label = 0;
  std::size_t first = 0;  // the label's instruction
  std::size_t last = 0;   // the terminator
  bool reached = false;
  bool stands_for_merge = false;  // never reached, but named as the end of a selection or a loop
  bool runs_once = false;         // begins a loop that never comes back
};

std::uint32_t binary(std::uint32_t op, std::uint32_t a, std::uint32_t b, bool& has) {
  const auto sa = static_cast<std::int32_t>(a);
  const auto sb = static_cast<std::int32_t>(b);
  switch (op) {
    case kOpIAdd: return a + b;
    case kOpISub: return a - b;
    case kOpIMul: return a * b;
    case kOpUDiv: has = b != 0; return has ? a / b : 0;
    case kOpUMod: has = b != 0; return has ? a % b : 0;
    case kOpShiftRightLogical: has = b < 32; return has ? a >> b : 0;
    case kOpShiftLeftLogical: has = b < 32; return has ? a << b : 0;
    case kOpBitwiseOr:
    case kOpLogicalOr: return a | b;
    case kOpBitwiseAnd:
    case kOpLogicalAnd: return a & b;
    case kOpBitwiseXor: return a ^ b;
    case kOpLogicalEqual:
    case kOpIEqual: return a == b;
    case kOpLogicalNotEqual:
    case kOpINotEqual: return a != b;
    case kOpUGreaterThan: return a > b;
    case kOpSGreaterThan: return sa > sb;
    case kOpUGreaterThanEqual: return a >= b;
    case kOpSGreaterThanEqual: return sa >= sb;
    case kOpULessThan: return a < b;
    case kOpSLessThan: return sa < sb;
    case kOpULessThanEqual: return a <= b;
    case kOpSLessThanEqual: return sa <= sb;
    default: has = false; return 0;
  }
}

// Values that nothing uses may be left out where these compute them.
bool is_pure(const Instruction& each) {
  const std::uint32_t op = each.op;
  if (op == kOpExtInst) return each.words[3] != kModf && each.words[3] != kFrexp;
  if (op == kOpLoad) return each.words.size() == 3;  // without memory operands: not volatile
  return op == kOpUndef || op == kOpAccessChain || op == kOpInBoundsAccessChain || op == kOpArrayLength ||
         op == kOpPhi || (op >= kOpVectorExtractDynamic && op <= kOpTranspose) ||
         (op >= kOpSampledImage && op <= kOpImageDrefGather) || (op >= kOpImage && op <= kOpImageQueryLevels) ||
         (op >= kOpConvertFToU && op <= kOpBitcast) || (op >= kOpSNegate && op <= kOpSMulExtended) ||
         (op >= kOpAny && op <= kOpFUnordGreaterThanEqual) || (op >= kOpShiftRightLogical && op <= kOpBitCount);
}

// The id that an instruction of a block defines; 0: none.
std::uint32_t result_of(const Instruction& each) {
  const std::uint32_t op = each.op;
  if (op == kOpLabel) return each.words[0];
  const bool none = (op >= kOpStore && op <= kOpCopyMemorySized) || op == kOpImageWrite || op == kOpControlBarrier ||
                    op == kOpMemoryBarrier || op == kOpAtomicStore || (op >= kOpLoopMerge && op <= kOpUnreachable);
  return none || each.words.size() < 2 ? 0 : each.words[1];
}

class Specialiser {
 public:
  std::vector<std::uint32_t> run(Spirv spirv, std::span<const SpecConstant> constants) {
    if (!read(spirv) || !take_globals(constants) || !find_blocks()) return {};
    while (sweep()) {
    }
    if (!keep_structure()) return {};
    choose();
    leave_out_unused();
    return write(spirv);
  }

 private:
  enum class Way : std::uint8_t { kLeaveOut, kKeep, kBranch, kPhi, kSwitch, kOnce };

  bool read(Spirv spirv) {
    if (spirv.size() < kSpirvHeaderWords || spirv[0] != kSpirvMagic || spirv[kSpirvBoundWord] > kIdsMax) return false;
    bound_ = spirv[kSpirvBoundWord];
    for (std::size_t at = kSpirvHeaderWords; at < spirv.size();) {
      const std::uint32_t words = spirv[at] >> 16;
      if (words == 0 || at + words > spirv.size()) return false;
      const std::uint32_t op = spirv[at] & 0xffff;
      if (op != kOpLine && op != kOpNoLine) instructions_.push_back({op, spirv.subspan(at + 1, words - 1)});
      at += words;
    }
    const auto function = std::find_if(instructions_.begin(), instructions_.end(),
                                       [](const Instruction& each) { return each.op == kOpFunction; });
    globals_ = static_cast<std::size_t>(function - instructions_.begin());
    known_.assign(bound_, kVarying);
    foldable_.assign(bound_, false);
    block_of_.assign(bound_, kNone);
    return true;
  }

  // Types, constants and specialisation constants.
  bool take_globals(std::span<const SpecConstant> constants) {
    std::vector<std::optional<std::uint32_t>> given(bound_);
    for (std::size_t i = 0; i < globals_; ++i) {
      const auto [op, words] = instructions_[i];
      if (op == kOpDecorate && words.size() == 3 && words[1] == kDecorationSpecId) {
        for (const SpecConstant& each : constants) {
          if (each.id == words[2]) given[words[0]] = each.value;
        }
      }
      if (op == kOpTypeInt && words[1] == 32) int_type_ = words[0];
      if (op == kOpTypeBool || (op == kOpTypeInt && words[1] == 32)) foldable_[words[0]] = true;
      if (op == kOpConstantTrue || op == kOpConstantFalse) known_[words[1]] = constant(op == kOpConstantTrue);
      if (op == kOpConstant && foldable_[words[0]]) known_[words[1]] = constant(words[2]);
      if (op == kOpSpecConstantTrue || op == kOpSpecConstantFalse) {
        known_[words[1]] = constant(given[words[1]].value_or(op == kOpSpecConstantTrue) != 0);
      }
      if (op == kOpSpecConstant) {
        if (!foldable_[words[0]]) return false;
        known_[words[1]] = constant(given[words[1]].value_or(words[2]));
      }
      if (op == kOpSpecConstantOp && foldable_[words[0]]) known_[words[1]] = fold({words[2], words.subspan(1)});
    }
    return true;
  }

  bool find_blocks() {
    for (std::size_t i = globals_; i < instructions_.size(); ++i) {
      const auto [op, words] = instructions_[i];
      if (op == kOpFunction) begins_ = true;
      if (op == kOpLabel) {
        block_of_[words[0]] = blocks_.size();
        blocks_.push_back({words[0], i, i, std::exchange(begins_, false), false});
      } else if (!blocks_.empty() && op >= kOpBranch && op <= kOpUnreachable) {
        blocks_.back().last = i;
      } else if (!blocks_.empty() && op != kOpFunctionParameter && value_type(instructions_[i]) != 0) {
        known_[words[1]] = {};  // until it is computed
      }
    }
    // Other terminators are of later versions than the frame's shaders.
    return std::all_of(blocks_.begin(), blocks_.end(), [](const Block& block) { return block.last > block.first; });
  }

  // The type of a value that is known if it is constant; 0: not one.
  [[nodiscard]] std::uint32_t value_type(const Instruction& each) const {
    const bool folds = each.op == kOpPhi || each.op == kOpCopyObject || each.op == kOpBitcast ||
                       (each.op >= kOpSNegate && each.op <= kOpSMulExtended) ||
                       (each.op >= kOpLogicalEqual && each.op <= kOpSLessThanEqual) ||
                       (each.op >= kOpShiftRightLogical && each.op <= kOpNot);
    return folds && foldable_[each.words[0]] ? each.words[0] : 0;
  }

  // words: one before the id of the value, the id, operands.
  [[nodiscard]] Known fold(const Instruction& each) const {
    const auto operand = [&](std::size_t i) {
      const std::uint32_t id = each.words[i + 2];
      return id < bound_ ? known_[id] : kVarying;
    };
    const std::size_t operands = each.words.size() - 2;
    if (each.op == kOpSelect && operands == 3) {
      const Known which = operand(0);
      return which.state == Known::kConstant ? operand(which.value != 0 ? 1 : 2) : which;
    }
    if (operands == 1) {
      const Known a = operand(0);
      if (a.state != Known::kConstant) return a;
      if (each.op == kOpCopyObject || each.op == kOpBitcast) return a;
      if (each.op == kOpLogicalNot) return constant(a.value == 0);
      if (each.op == kOpNot) return constant(~a.value);
      if (each.op == kOpSNegate) return constant(0u - a.value);
      return kVarying;
    }
    if (operands != 2) return kVarying;
    const Known a = operand(0);
    const Known b = operand(1);
    for (const Known& one : {a, b}) {  // it may decide alone
      if (one.state != Known::kConstant) continue;
      if (each.op == kOpLogicalAnd && one.value == 0) return constant(0);
      if (each.op == kOpLogicalOr && one.value != 0) return constant(1);
    }
    if (a.state == Known::kNothingYet || b.state == Known::kNothingYet) return {};
    if (a.state == Known::kVaries || b.state == Known::kVaries) return kVarying;
    bool has = true;
    const std::uint32_t value = binary(each.op, a.value, b.value, has);
    return has ? constant(value) : kVarying;
  }

  [[nodiscard]] Known meet(const Instruction& phi, std::size_t block) const {
    Known all;
    for (std::size_t i = 2; i + 1 < phi.words.size(); i += 2) {
      const std::size_t from = block_of_[phi.words[i + 1]];
      if (from == kNone || !goes_to(from, block)) continue;
      const Known one = known_[phi.words[i]];
      if (one.state == Known::kNothingYet) continue;
      if (all.state == Known::kNothingYet) all = one;
      if (one != all) return kVarying;
    }
    return all;
  }

  template <class Take>
  void for_each_target(std::size_t from, const Take& take) const {
    const Instruction& end = instructions_[blocks_[from].last];
    if (end.op == kOpBranch) {
      take(block_of_[end.words[0]]);
    } else if (end.op == kOpBranchConditional) {
      const std::size_t yes = block_of_[end.words[1]];
      const std::size_t no = block_of_[end.words[2]];
      const Known which = taken(from, end);
      if (which.state == Known::kNothingYet) return;
      if (which.state == Known::kVaries || which.value != 0) take(yes);
      if (which.state == Known::kVaries || which.value == 0) take(no);
    } else if (end.op == kOpSwitch) {
      const Known which = known_[end.words[0]];
      if (which.state == Known::kNothingYet) return;
      if (which.state == Known::kConstant) return take(block_of_[case_of(end, which.value)]);
      take(block_of_[end.words[1]]);
      for (std::size_t i = 3; i < end.words.size(); i += 2) take(block_of_[end.words[i]]);
    }
  }
  [[nodiscard]] bool goes_to(std::size_t from, std::size_t to) const {
    bool goes = false;
    if (blocks_[from].reached) for_each_target(from, [&](std::size_t target) { goes = goes || target == to; });
    return goes;
  }
  // The condition of a branch. One that goes back to the head of a loop stays, since a loop needs it.
  [[nodiscard]] Known taken(std::size_t from, const Instruction& end) const {
    const bool back = block_of_[end.words[1]] <= from || block_of_[end.words[2]] <= from;
    return back ? kVarying : known_[end.words[0]];
  }
  [[nodiscard]] static std::uint32_t case_of(const Instruction& end, std::uint32_t value) {
    for (std::size_t i = 2; i + 1 < end.words.size(); i += 2) {
      if (end.words[i] == value) return end.words[i + 1];
    }
    return end.words[1];
  }

  // Once over all blocks that are reached. True: something has become known.
  bool sweep() {
    bool changed = false;
    for (std::size_t block = 0; block < blocks_.size(); ++block) {
      if (!blocks_[block].reached) continue;
      for (std::size_t i = blocks_[block].first + 1; i < blocks_[block].last; ++i) {
        const Instruction& each = instructions_[i];
        if (value_type(each) == 0) continue;
        const Known now = each.op == kOpPhi ? meet(each, block) : fold(each);
        if (now == known_[each.words[1]]) continue;
        known_[each.words[1]] = now;
        changed = true;
      }
      for_each_target(block, [&](std::size_t target) {
        changed = changed || !blocks_[target].reached;
        blocks_[target].reached = true;
      });
    }
    return changed;
  }

  // False: the blocks that are left do not make a module, which no shader of the frame has shown so far.
  bool keep_structure() {
    std::vector<bool> comes_back(blocks_.size(), false);
    for (std::size_t from = 0; from < blocks_.size(); ++from) {
      if (!blocks_[from].reached) continue;
      for_each_target(from, [&](std::size_t to) { comes_back[to] = comes_back[to] || to <= from; });
    }
    for (std::size_t from = 0; from < blocks_.size(); ++from) {
      if (!blocks_[from].reached) continue;
      if (comes_back[from] != is_loop(from) && !can_run_once(from)) return false;
      blocks_[from].runs_once = !comes_back[from] && is_loop(from);
      const Instruction& end = instructions_[blocks_[from].last];
      const Instruction* merge = merge_of(from);
      if (merge == nullptr) continue;
      const bool ends = merge->op == kOpSelectionMerge && end.op == kOpBranchConditional &&
                        known_[end.words[0]].state == Known::kConstant;
      Block& after = blocks_[block_of_[merge->words[0]]];
      if (!ends && !after.reached) after.stands_for_merge = true;
    }
    return true;
  }
  // A loop that never comes back becomes a switch of one case, which can be left from within as a loop can. Not from
  // within another switch.
  [[nodiscard]] bool can_run_once(std::size_t from) const {
    if (!is_loop(from) || int_type_ == 0) return false;
    const Instruction& end = instructions_[blocks_[from].last];
    if (end.op != kOpBranch && taken(from, end).state != Known::kConstant) return false;
    for (std::size_t block = from + 1; block < block_of_[merge_of(from)->words[0]]; ++block) {
      if (blocks_[block].reached && instructions_[blocks_[block].last].op == kOpSwitch) return false;
    }
    return true;
  }
  [[nodiscard]] const Instruction* merge_of(std::size_t block) const {
    const Instruction& each = instructions_[blocks_[block].last - 1];
    return each.op == kOpLoopMerge || each.op == kOpSelectionMerge ? &each : nullptr;
  }
  [[nodiscard]] bool is_loop(std::size_t block) const {
    const Instruction* merge = merge_of(block);
    return merge != nullptr && merge->op == kOpLoopMerge;
  }

  // What becomes of each instruction of a function.
  void choose() {
    ways_.assign(instructions_.size(), Way::kKeep);
    for (std::size_t block = 0; block < blocks_.size(); ++block) {
      const auto [label, first, last, reached, stands_for_merge, runs_once] = blocks_[block];
      const Instruction& end = instructions_[last];
      for (std::size_t i = first; i <= last; ++i) {
        const Instruction& each = instructions_[i];
        if (!reached || is_constant(each)) {
          ways_[i] = Way::kLeaveOut;
        } else if (each.op == kOpPhi) {
          ways_[i] = Way::kPhi;
        }
      }
      if (!reached) continue;
      if (runs_once) {
        ways_[last - 1] = ways_[last] = Way::kOnce;
        continue;
      }
      if (end.op == kOpSwitch && known_[end.words[0]].state == Known::kConstant) ways_[last] = Way::kSwitch;
      if (end.op != kOpBranchConditional || taken(block, end).state != Known::kConstant) continue;
      ways_[last] = Way::kBranch;
      if (instructions_[last - 1].op == kOpSelectionMerge) ways_[last - 1] = Way::kLeaveOut;
    }
  }
  [[nodiscard]] bool is_constant(const Instruction& each) const {
    return value_type(each) != 0 && known_[each.words[1]].state == Known::kConstant;
  }

  // A word that equals the id of a value counts as its use, also where it is a number: a few values too many stay.
  void leave_out_unused() {
    std::vector<std::size_t> makes(bound_, kNone);
    std::vector<std::size_t> used;
    for (std::size_t i = globals_; i < instructions_.size(); ++i) {
      if (ways_[i] == Way::kLeaveOut) continue;
      if (is_pure(instructions_[i])) {
        makes[instructions_[i].words[1]] = i;
      } else {
        used.push_back(i);
      }
    }
    std::vector<bool> keeps(instructions_.size(), false);
    while (!used.empty()) {
      const std::size_t i = used.back();
      used.pop_back();
      for (const std::uint32_t word : instructions_[i].words) {
        if (word >= bound_ || makes[word] == kNone || keeps[makes[word]]) continue;
        keeps[makes[word]] = true;
        used.push_back(makes[word]);
      }
    }
    for (std::size_t i = globals_; i < instructions_.size(); ++i) {
      if (ways_[i] != Way::kLeaveOut && is_pure(instructions_[i]) && !keeps[i]) ways_[i] = Way::kLeaveOut;
    }
  }

  void put(std::uint32_t op, std::span<const std::uint32_t> words) {
    out_.push_back(static_cast<std::uint32_t>(words.size() + 1) << 16 | op);
    out_.insert(out_.end(), words.begin(), words.end());
  }
  void put_constant(std::uint32_t type, std::uint32_t id, std::uint32_t value, bool boolean) {
    const std::uint32_t words[] = {type, id, value};
    if (boolean) return put(value != 0 ? kOpConstantTrue : kOpConstantFalse, std::span(words, 2));
    put(kOpConstant, words);
  }

  std::vector<std::uint32_t> write(Spirv spirv) {
    out_.reserve(spirv.size());
    out_.assign(spirv.begin(), spirv.begin() + kSpirvHeaderWords);
    std::vector<bool> gone(bound_, false);  // ids that lose their decorations
    std::uint32_t boolean = 0;
    for (std::size_t i = 0; i < instructions_.size(); ++i) {
      const auto [op, words] = instructions_[i];
      if (op == kOpTypeBool) boolean = words[0];
      if (i < globals_ || ways_[i] != Way::kLeaveOut) continue;
      gone[result_of(instructions_[i])] = true;
    }
    for (std::size_t i = 0; i < globals_; ++i) write_global(instructions_[i], gone, boolean);
    for (std::size_t i = globals_; i < instructions_.size(); ++i) {
      const Instruction& each = instructions_[i];
      if (ways_[i] != Way::kLeaveOut || !is_constant(each)) continue;
      put_constant(each.words[0], each.words[1], known_[each.words[1]].value, each.words[0] == boolean);
    }
    if (int_type_ != 0) put_constant(int_type_, out_[kSpirvBoundWord]++, 0, false);
    for (std::size_t i = globals_; i < instructions_.size(); ++i) write_local(i);
    return std::move(out_);
  }

  void write_global(const Instruction& each, const std::vector<bool>& gone, std::uint32_t boolean) {
    const auto [op, words] = each;
    if (op == kOpName || op == kOpMemberName) return;
    if (op == kOpDecorate && (words[1] == kDecorationSpecId || gone[words[0]])) return;
    const bool spec = op >= kOpSpecConstantTrue && op <= kOpSpecConstantOp;
    if (spec && op != kOpSpecConstantComposite && known_[words[1]].state == Known::kConstant) {
      return put_constant(words[0], words[1], known_[words[1]].value, words[0] == boolean);
    }
    const bool plain = op == kOpSpecConstantComposite &&
                       std::all_of(words.begin() + 2, words.end(),
                                   [&](std::uint32_t id) { return known_[id].state == Known::kConstant; });
    put(plain ? kOpConstantComposite : op, words);
  }

  void write_local(std::size_t i) {
    const auto [op, words] = instructions_[i];
    if (ways_[i] == Way::kLeaveOut) {
      if (op != kOpLabel || !blocks_[block_of_[words[0]]].stands_for_merge) return;
      put(kOpLabel, words);
      return put(kOpUnreachable, {});
    }
    if (op == kOpLabel) at_ = block_of_[words[0]];
    if (ways_[i] == Way::kOnce && op == kOpLoopMerge) return put(kOpSelectionMerge, std::array{words[0], 0u});
    if (ways_[i] == Way::kOnce) return put(kOpSwitch, std::array{bound_, target_of(instructions_[i])});
    if (ways_[i] == Way::kBranch) return put(kOpBranch, std::array{target_of(instructions_[i])});
    if (ways_[i] == Way::kSwitch) {
      return put(op, std::array{words[0], case_of(instructions_[i], known_[words[0]].value)});
    }
    if (ways_[i] != Way::kPhi) return put(op, words);
    std::vector<std::uint32_t> kept(words.begin(), words.begin() + 2);
    for (std::size_t at = 2; at + 1 < words.size(); at += 2) {
      if (goes_to(block_of_[words[at + 1]], at_)) kept.insert(kept.end(), {words[at], words[at + 1]});
    }
    put(op, kept);
  }

  // Of a branch that goes one way.
  [[nodiscard]] std::uint32_t target_of(const Instruction& end) const {
    if (end.op == kOpBranch) return end.words[0];
    return end.words[known_[end.words[0]].value != 0 ? 1 : 2];
  }

  static constexpr std::size_t kNone = ~std::size_t{0};
  std::uint32_t bound_ = 0;
  std::vector<Instruction> instructions_;
  std::uint32_t int_type_ = 0;         // of 32 bits; 0: the module has none
  std::size_t globals_ = 0;            // of instructions_: those before the functions
  std::vector<Known> known_;           // by id
  std::vector<bool> foldable_;         // types: by id
  std::vector<std::size_t> block_of_;  // by the label's id
  std::vector<Block> blocks_;
  bool begins_ = false;  // the next block is the first of a function
  std::vector<Way> ways_;
  std::vector<std::uint32_t> out_;
  std::size_t at_ = 0;  // the block that is being written
};

}  // namespace

std::vector<std::uint32_t> specialised(Spirv spirv, std::span<const SpecConstant> constants) {
  return Specialiser().run(spirv, constants);
}

}  // namespace footlight::render::vk
