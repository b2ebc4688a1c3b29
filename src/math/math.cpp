// SPDX-License-Identifier: Apache-2.0
// The math room is headers; this file compiles them alone.
#include "math/affine.h"
#include "math/types.h"
