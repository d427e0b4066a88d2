// What the compiler flags grant, and the inline namespace that keeps differently built objects apart.
//
// Two translation units built with other instruction sets hold other bodies of the same inline
// functions. The linker would silently keep one of them; with the tag in the name it keeps both.
#pragma once

#include <billow/core/version.hpp>

/// Define BILLOW_SCALAR to build without vector lanes: the reference that tests compare with.
#if defined(BILLOW_SCALAR) || !(defined(__GNUC__) || defined(__clang__))
#define BILLOW_LANES 1
#define BILLOW_ISA scalar
#elif defined(__AVX512F__)
#define BILLOW_LANES 16
#define BILLOW_ISA avx512
#elif defined(__AVX2__)
#define BILLOW_LANES 8
#define BILLOW_ISA avx2
#else
#define BILLOW_LANES 4  // SSE2, NEON, or what the compiler makes of four floats
#define BILLOW_ISA x4
#endif

#if defined(_OPENMP)
#define BILLOW_THREADING omp
#else
#define BILLOW_THREADING serial
#endif

#define BILLOW_DETAIL_JOIN_(a, b, c) a##_##b##_##c
#define BILLOW_DETAIL_JOIN(a, b, c) BILLOW_DETAIL_JOIN_(a, b, c)
#define BILLOW_ABI BILLOW_DETAIL_JOIN(v0, BILLOW_ISA, BILLOW_THREADING)

#define BILLOW_DETAIL_TEXT_(a) #a
#define BILLOW_DETAIL_TEXT(a) BILLOW_DETAIL_TEXT_(a)
/// The tag as text, e.g. "v0_avx2_omp".
#define BILLOW_ABI_NAME BILLOW_DETAIL_TEXT(BILLOW_ABI)

/// Checks what the caller must guarantee. Off with NDEBUG; define it yourself to replace it.
#ifndef BILLOW_ASSERT
#include <cassert>
#define BILLOW_ASSERT(condition) assert(condition)
#endif
