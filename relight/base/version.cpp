// SPDX-License-Identifier: Apache-2.0
#include "relight/base/version.h"

namespace relight {

const char* Version() { return RELIGHT_VERSION; }

}  // namespace relight
