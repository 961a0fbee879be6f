// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/transport_options.h"

#include "tests/relight/capture/temporary_folder.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

TEST(TransportOptions, ThePapersMethodHasThePapersTransport) {
  const ArrivingLightOptions papers = TransportOf(Method::kCabral2011, OurTransport());
  EXPECT_EQ(papers.sun_directions, 1);
  EXPECT_EQ(papers.own_shade, 1.0);
  EXPECT_EQ(TransportOf(Method::kDefault, {.own_shade = 0.3}).own_shade, 0.3);
}

TEST(TransportOptions, WhatThePaperDoesNotHaveIsRefused) {
  ArrivingLightOptions options = OurTransport();
  options.own_shade = 0.5;
  const std::string message =
      tests::MessageOf<OptionError>([&] { TransportOf(Method::kCabral2011, options); });
  for (const char* word : {"cabral2011", "--own-shade"})
    EXPECT_TRUE(tests::Holds(message, word)) << message;
  EXPECT_THROW(TransportOf(Method::kDefault, {.own_shade = 2}), OptionError);
  for (const auto& change :
       {+[](ArrivingLightOptions& o) { o.gap_length_m = 0.05; },
        +[](ArrivingLightOptions& o) { o.clumping = 0.3; },
        +[](ArrivingLightOptions& o) { o.leaf_transmission = 0.4; },
        +[](ArrivingLightOptions& o) { o.multiple_scattering = 0.3; },
        +[](ArrivingLightOptions& o) { o.bounce = true; }}) {
    ArrivingLightOptions one = OurTransport();
    change(one);
    EXPECT_THROW(TransportOf(Method::kCabral2011, one), OptionError);
    EXPECT_EQ(TransportOf(Method::kDefault, one), one);
  }
}

}  // namespace
}  // namespace relight
