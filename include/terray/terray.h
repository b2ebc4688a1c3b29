// SPDX-License-Identifier: Apache-2.0
// The whole public API.
#pragma once

#include "terray/bake.h"
#include "terray/flight.h"
#include "terray/options.h"
#include "terray/process.h"
#include "terray/query.h"
#include "terray/renderer.h"
#include "terray/result.h"
#include "terray/stats.h"
#include "terray/terrain.h"
#include "terray/version.h"
#include "terray/view.h"
