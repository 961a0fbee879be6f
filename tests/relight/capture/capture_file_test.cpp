// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/capture_file.h"

#include "relight/base/error.h"
#include "tests/relight/capture/temporary_folder.h"

#include <gtest/gtest.h>

#include <array>

namespace relight {
namespace {

using tests::Holds;
using tests::MessageOf;

class CaptureFileTest : public tests::TemporaryFolder {
 protected:
  CaptureFile Parse(const std::string& text) {
    return ReadCaptureFile(Write("capture.toml", text));
  }
  std::string Refusal(const std::string& text) {
    return MessageOf<InputError>([&] { Parse(text); });
  }
};

TEST_F(CaptureFileTest, ReadsAllThatItsHeaderShows) {
  const CaptureFile capture = Parse(R"(place = [40.35, -74.65, 20.0]
zone = "America/New_York"
taken = "2011-07-22T13:00:00-04:00"
heading = 359.25

[[view]]
photo = "photos/view_00.jpg"

[[view]]
name = "south"
photo = "photos/a b.JPG"
taken = "2011-07-22T14:00"

[options]
turbidity = 3.5
cells = 100
densify = true
method = "default"
)");
  EXPECT_EQ(capture.place, "40.35,-74.65,20");
  EXPECT_EQ(capture.zone, "America/New_York");
  EXPECT_EQ(capture.taken, "2011-07-22T13:00:00-04:00");
  EXPECT_EQ(capture.heading_deg, 359.25);
  ASSERT_EQ(capture.views.size(), 2u);
  EXPECT_EQ(capture.views[0].name, "view_00");
  EXPECT_EQ(capture.views[0].taken, std::nullopt);
  EXPECT_EQ(capture.views[1].name, "south");
  EXPECT_EQ(capture.views[1].photo, "photos/a b.JPG");
  EXPECT_EQ(capture.views[1].taken, "2011-07-22T14:00");
  EXPECT_EQ(capture.options.at("turbidity").text, "3.5");
  EXPECT_EQ(capture.options.at("cells").text, "100");
  EXPECT_EQ(capture.options.at("densify").text, "true");
  EXPECT_TRUE(Holds(capture.options.at("method").where, "capture.toml:18"));
}

TEST_F(CaptureFileTest, EmptyIsAllowed) {
  const CaptureFile capture = Parse("");
  EXPECT_TRUE(capture.views.empty());
  EXPECT_FALSE(capture.place);
}

TEST_F(CaptureFileTest, TomlsOwnTimesAreTimes) {
  EXPECT_EQ(Parse("taken = 2011-07-22T13:00:00-04:00").taken,
            "2011-07-22T13:00:00-04:00");
  EXPECT_EQ(Parse("taken = 2011-07-22T13:00:00").taken, "2011-07-22T13:00:00");
}

TEST_F(CaptureFileTest, ErrorsNameFileLineAndRemedy) {
  struct Case {
    const char *text, *line, *remedy;
  };
  constexpr std::array kCases = {
      Case{"a = [", ":1: ", "mend this line"},
      Case{"\n\nplace = \"here\"", ":3: ", "LAT,LON"},
      Case{"place = [91, 0]", ":1: ", "-90 to 90"},
      Case{"place = [1]", ":1: ", "[latitude, longitude]"},
      Case{"zone = \"Mars/Olympus\"", ":1: ", "Mars/Olympus"},
      Case{"zone = 1", ":1: ", "Europe/Paris"},
      Case{"\ntaken = \"noon\"", ":2: ", "17:00"},
      Case{"heading = \"N\"", ":1: ", "number"},
      Case{"heading = -400", ":1: ", "0 to 360"},
      Case{"heading = nan", ":1: ", "0 to 360"},
      Case{"plase = 1", ":1: ", "place, zone"},
      Case{"view = 1", ":1: ", "[[view]]"},
      Case{"[[view]]\nname = \"a\"", ":1: ", "photo = "},
      Case{"[[view]]\nphoto = \"a.jpg\"\nfoto = 1", ":3: ", "name, photo"},
      Case{"[[view]]\nphoto = \"a.jpg\"\n[[view]]\nphoto = \"b/a.png\"",
           ":3: ",
           "another name"},
      Case{"options = 1", ":1: ", "[options]"},
      Case{"[options]\ncells = [1]", ":2: ", "number"}};
  for (const Case& c : kCases) {
    SCOPED_TRACE(c.text);
    const std::string message = Refusal(c.text);
    EXPECT_TRUE(Holds(message, "capture.toml" + std::string(c.line))) << message;
    EXPECT_TRUE(Holds(message, c.remedy)) << message;
  }
}

TEST_F(CaptureFileTest, NamesThatLeadOutAreRefused) {
  for (const char* photo : {"/etc/passwd",
                            "../a.jpg",
                            "a/../../b.jpg",
                            "",
                            "a/",
                            "..",
                            "C:\\\\a.jpg",
                            "a\\nb.jpg"}) {
    SCOPED_TRACE(photo);
    EXPECT_TRUE(
        Holds(Refusal("[[view]]\nphoto = \"" + std::string(photo) + "\""), ":1: "));
  }
  for (const char* name : {"../a", "/a", "a/b", "..", ""}) {
    SCOPED_TRACE(name);
    Refusal("[[view]]\nphoto = \"a.jpg\"\nname = \"" + std::string(name) + "\"");
  }
}

TEST_F(CaptureFileTest, WhatIsWrittenIsReadAgain) {
  CaptureFile capture;
  capture.zone = "Europe/Paris";
  capture.heading_deg = 12.5;
  capture.views = {{"a", "photos/a.jpg", {}},
                   {"it's \"b\"", "photos/it's \"b\".jpg", "2011-07-22T13:00"}};
  capture.options["cells"] = {"40", ""};
  const CaptureFile again = Parse(CaptureFileText(capture));
  EXPECT_EQ(again.place, std::nullopt);
  EXPECT_EQ(again.zone, capture.zone);
  EXPECT_EQ(again.heading_deg, capture.heading_deg);
  ASSERT_EQ(again.views.size(), 2u);
  EXPECT_EQ(again.views[1].name, capture.views[1].name);
  EXPECT_EQ(again.views[1].photo, capture.views[1].photo);
  EXPECT_EQ(again.views[1].taken, capture.views[1].taken);
  EXPECT_EQ(again.options.at("cells").text, "40");

  // Views may be appended, below [options] too
  const ViewEntry added{"c", "photos/c.jpg", {}};
  const CaptureFile more = Parse(CaptureFileText(capture) + ViewsText({&added, 1}));
  ASSERT_EQ(more.views.size(), 3u);
  EXPECT_EQ(more.views[2].name, "c");
  EXPECT_EQ(more.options.at("cells").text, "40");
}

}  // namespace
}  // namespace relight
