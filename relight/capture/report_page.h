// SPDX-License-Identifier: Apache-2.0
#pragma once

// The frame of the pages "--report" writes: one HTML file each, nothing loaded from
// elsewhere, dark, pictures that a click makes large.

#include <opencv2/core.hpp>

#include <string>
#include <vector>

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

// A small picture for a contact sheet that leads to the figure of that id; without one
// when it is empty. Each line in plain text; `is_off`: the last is a warning.
std::string ReportThumbnail(const std::string& figure_id,
                            const std::string& alt,
                            const std::vector<std::string>& lines,
                            bool is_off,
                            const cv::Mat3b& picture);

// "%.*f", and never "-0.0".
std::string Fixed(double value, int digits);

}  // namespace relight
