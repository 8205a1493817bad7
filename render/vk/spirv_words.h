// Words of SPIR-V that this program reads or writes: the specification 1.6, sections 2.3 (the module), 3.20
// (decorations) and 3.49 (instructions).
#pragma once

#include <cstddef>
#include <cstdint>

namespace footlight::render::vk {

inline constexpr std::uint32_t kSpirvMagic = 0x07230203;
inline constexpr std::size_t kSpirvHeaderWords = 5;
inline constexpr std::size_t kSpirvBoundWord = 3;  // of the header: ids are below it

inline constexpr std::uint32_t kDecorationSpecId = 1;
inline constexpr std::uint32_t kDecorationBinding = 33;
inline constexpr std::uint32_t kDecorationDescriptorSet = 34;

enum SpirvOp : std::uint32_t {
  kOpUndef = 1,
  kOpName = 5,
  kOpMemberName = 6,
  kOpLine = 8,
  kOpExtInst = 12,
  kOpTypeVoid = 19,  // the first of the types
  kOpTypeBool = 20,
  kOpTypeInt = 21,
  kOpTypeFloat = 22,
  kOpTypeImage = 25,
  kOpTypeSampledImage = 27,
  kOpTypeStruct = 30,
  kOpTypePointer = 32,
  kOpConstantTrue = 41,
  kOpConstantFalse = 42,
  kOpConstant = 43,
  kOpConstantComposite = 44,
  kOpSpecConstantTrue = 48,
  kOpSpecConstantFalse = 49,
  kOpSpecConstant = 50,
  kOpSpecConstantComposite = 51,
  kOpSpecConstantOp = 52,
  kOpFunction = 54,
  kOpFunctionParameter = 55,
  kOpVariable = 59,
  kOpLoad = 61,
  kOpStore = 62,
  kOpCopyMemorySized = 64,
  kOpAccessChain = 65,
  kOpInBoundsAccessChain = 66,
  kOpArrayLength = 68,
  kOpDecorate = 71,
  kOpVectorExtractDynamic = 77,
  kOpCopyObject = 83,
  kOpTranspose = 84,
  kOpSampledImage = 86,
  kOpImageDrefGather = 97,
  kOpImageWrite = 99,
  kOpImage = 100,
  kOpImageQueryLevels = 106,
  kOpConvertFToU = 109,
  kOpBitcast = 124,
  kOpSNegate = 126,
  kOpIAdd = 128,
  kOpISub = 130,
  kOpIMul = 132,
  kOpUDiv = 134,
  kOpUMod = 137,
  kOpSMulExtended = 152,
  kOpAny = 154,
  kOpLogicalEqual = 164,
  kOpLogicalNotEqual = 165,
  kOpLogicalOr = 166,
  kOpLogicalAnd = 167,
  kOpLogicalNot = 168,
  kOpSelect = 169,
  kOpIEqual = 170,
  kOpINotEqual = 171,
  kOpUGreaterThan = 172,
  kOpSGreaterThan = 173,
  kOpUGreaterThanEqual = 174,
  kOpSGreaterThanEqual = 175,
  kOpULessThan = 176,
  kOpSLessThan = 177,
  kOpULessThanEqual = 178,
  kOpSLessThanEqual = 179,
  kOpFUnordGreaterThanEqual = 191,
  kOpShiftRightLogical = 194,
  kOpShiftLeftLogical = 196,
  kOpBitwiseOr = 197,
  kOpBitwiseXor = 198,
  kOpBitwiseAnd = 199,
  kOpNot = 200,
  kOpBitCount = 205,
  kOpControlBarrier = 224,
  kOpMemoryBarrier = 225,
  kOpAtomicStore = 228,
  kOpPhi = 245,
  kOpLoopMerge = 246,
  kOpSelectionMerge = 247,
  kOpLabel = 248,
  kOpBranch = 249,
  kOpBranchConditional = 250,
  kOpSwitch = 251,
  kOpUnreachable = 255,
  kOpNoLine = 317,
};

}  // namespace footlight::render::vk
