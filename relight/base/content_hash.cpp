// SPDX-License-Identifier: Apache-2.0
#include "relight/base/content_hash.h"

#include "relight/base/error.h"

#include <xxhash.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <system_error>
#include <vector>

namespace relight {
namespace {

std::string Hexadecimal(XXH128_hash_t hash) {
  static constexpr char kDigits[] = "0123456789abcdef";
  XXH128_canonical_t bytes;
  XXH128_canonicalFromHash(&bytes, hash);
  std::string text;
  for (const unsigned char byte : bytes.digest) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

}  // namespace

struct ContentHash::State {
  std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> hash{XXH3_createState(),
                                                                &XXH3_freeState};
};

ContentHash::ContentHash() : state_(std::make_unique<State>()) {
  XXH3_128bits_reset(state_->hash.get());
}
ContentHash::~ContentHash() = default;

void ContentHash::Add(std::string_view piece) {
  XXH3_128bits_update(state_->hash.get(), piece.data(), piece.size());
}

std::string ContentHash::Text() const {
  return Hexadecimal(XXH3_128bits_digest(state_->hash.get()));
}

std::string HashOfText(std::string_view text) {
  return Hexadecimal(XXH3_128bits(text.data(), text.size()));
}

std::string HashOfFile(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw InputError(file.string() +
                     ": cannot be read: " + std::generic_category().message(errno));
  ContentHash hash;
  std::vector<char> buffer(std::size_t{1} << 20);
  while (in.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) ||
         in.gcount() > 0) {
    hash.Add({buffer.data(), static_cast<std::size_t>(in.gcount())});
  }
  if (in.bad()) throw InputError(file.string() + ": cannot be read to its end");
  return hash.Text();
}

}  // namespace relight
