// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace relight {

// "0.1.0".
const char* Version();

}  // namespace relight
