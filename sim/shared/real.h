// The common subset of C++ and GLSL in which time behaviour, decoding and light formulas are written once.
//
// A shared header has no include guard and includes nothing. In GLSL it is included after this file, with Real = float.
// In C++ it is included twice, through sim/shared/shared.h or its neighbours in fixtures/ and render/: inside namespace
// f32 with Real = float (what the GPU computes) and inside namespace f64 with Real = double (the reference).
//
// FL_EXACT before a variable: its value must be bit-identical on CPU and GPU, so the compiler must not contract it to a
// fused multiply-add (the C++ is compiled for processors without one).
//
// The rules of the subset: literals as Real(0.5) or uint(3); Vec2, Vec3 for vectors; FL_FN before a function (FL_INLINE
// if copying structs in a call costs more than its work); FL_IN(T) for a large struct that is only read, FL_INOUT(T)
// and FL_OUT(T) for parameters that change; no templates, references, pointers, member functions or overloads on Real;
// arrays of fixed size; comparisons written so that NaN takes the safe branch.
#ifdef __cplusplus
#define FL_FN inline
#define FL_INLINE [[gnu::always_inline]] inline
#define FL_IN(T) const T&
#define FL_INOUT(T) T&
#define FL_OUT(T) T&
#define FL_CONST constexpr
#define FL_EXACT
#define FL_LIST_BEGIN(T, n) {
#define FL_LIST_END }
#define FL_ATAN2(y, x) std::atan2(y, x)
#else
#define FL_FN
#define FL_INLINE
#define FL_IN(T) in T
#define FL_INOUT(T) inout T
#define FL_OUT(T) out T
#define FL_CONST const
#define FL_EXACT precise
#define FL_LIST_BEGIN(T, n) T[n](
#define FL_LIST_END )
#define FL_ATAN2(y, x) atan(y, x)
#define Real float
#define Vec2 vec2
#define Vec3 vec3
#define Turns uvec2
#endif
