// Asserts that libenv.h has the binary layout that hosts were compiled against.

#include <cstddef>

#include "clients/libenv/libenv.h"

static_assert(sizeof(void*) == 8 && sizeof(int) == 4, "the layout is that of 64-bit Linux");

static_assert(sizeof(LibenvValue) == 4);

static_assert(sizeof(LibenvTensorType) == 212);
static_assert(offsetof(LibenvTensorType, name) == 0);
static_assert(offsetof(LibenvTensorType, scalar_type) == 128);
static_assert(offsetof(LibenvTensorType, value_type) == 132);
static_assert(offsetof(LibenvTensorType, shape) == 136);
static_assert(offsetof(LibenvTensorType, dimension_count) == 200);
static_assert(offsetof(LibenvTensorType, low) == 204);
static_assert(offsetof(LibenvTensorType, high) == 208);

static_assert(sizeof(LibenvOption) == 144);
static_assert(offsetof(LibenvOption, value_type) == 128);
static_assert(offsetof(LibenvOption, count) == 132);
static_assert(offsetof(LibenvOption, data) == 136);

static_assert(sizeof(LibenvOptions) == 16);
static_assert(offsetof(LibenvOptions, items) == 0);
static_assert(offsetof(LibenvOptions, count) == 8);

static_assert(sizeof(LibenvBuffers) == 40);
static_assert(offsetof(LibenvBuffers, observations) == 0);
static_assert(offsetof(LibenvBuffers, rewards) == 8);
static_assert(offsetof(LibenvBuffers, firsts) == 16);
static_assert(offsetof(LibenvBuffers, infos) == 24);
static_assert(offsetof(LibenvBuffers, actions) == 32);
