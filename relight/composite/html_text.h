// SPDX-License-Identifier: Apache-2.0
#pragma once

// Texts and pictures inside of a page that is one file.

#include <string>

namespace relight {

// Of a picture for "data:image/jpeg;base64,…".
std::string Base64(const std::string& bytes);

// Text as it may stand in an element or an attribute.
std::string HtmlEscaped(const std::string& text);

}  // namespace relight
