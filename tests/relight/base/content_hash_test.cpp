// SPDX-License-Identifier: Apache-2.0
#include "relight/base/content_hash.h"

#include <gtest/gtest.h>

#include <string>

namespace relight {
namespace {

TEST(ContentHash, OfPiecesIsThatOfTheWhole) {
  std::string text;
  for (int i = 0; i < 5000; ++i) text += std::to_string(i * i);
  ContentHash hash;
  EXPECT_EQ(hash.Text(), HashOfText(""));
  std::size_t at = 0;
  for (std::size_t length = 0; at < text.size(); length = 2 * length + 1) {
    const std::string piece = text.substr(at, length);
    hash.Add(piece);
    at += piece.size();
    EXPECT_EQ(hash.Text(), HashOfText(text.substr(0, at)));
  }
  EXPECT_NE(hash.Text(), HashOfText(text + "0"));
}

}  // namespace
}  // namespace relight
