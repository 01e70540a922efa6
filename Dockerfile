# The command in an image: docker build -t srp . && docker run --rm -v "$PWD:/work" srp render -o out.png
# Simulators are compiled while a program runs, so the image has rustc and a linker; without them the interpreter takes their place.
ARG RUST=1.95

FROM rust:${RUST}-slim AS build
WORKDIR /source
COPY . .
RUN cargo install --locked --path . --root /installed

FROM rust:${RUST}-slim
COPY --from=build /installed/bin/srp /usr/local/bin/srp
# Schedules and simulators, kept from one run to the next in a volume at this place.
ENV SRP_CACHE=/cache
RUN useradd --create-home srp && install -d -m 700 -o srp -g srp /cache && install -d -o srp -g srp /work
USER srp
VOLUME /cache
WORKDIR /work
ENTRYPOINT ["srp"]
