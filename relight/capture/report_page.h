// SPDX-License-Identifier: Apache-2.0
#pragma once

// The frame of the pages "--report" writes: one HTML file each, nothing loaded from
// elsewhere, dark, pictures that a click makes large.

#include <opencv2/core.hpp>

#include <string>

namespace relight {

// Everything before the page's own content; `title` in plain text.
std::string ReportHead(const std::string& title);
std::string ReportFoot();

// A row of a table of two columns, both in plain text.
std::string ReportRow(const std::string& what, const std::string& value);

// A picture with what it shows, in plain text, and an id for links and tests.
std::string ReportFigure(const std::string& id,
                         const std::string& alt,
                         const std::string& caption,
                         const cv::Mat3b& picture);

// "%.*f".
std::string Fixed(double value, int digits);

}  // namespace relight
