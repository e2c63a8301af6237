# foundry with what draws 3D scenes. `docker build -t foundry .`, then in any folder:
# docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/work" foundry -m model=scripted/random seed=0-4
FROM debian:bookworm-slim
RUN apt-get update \
 && apt-get install -y --no-install-recommends ca-certificates python3 python3-venv libegl1 libgl1-mesa-dri \
 && rm -rf /var/lib/apt/lists/*
COPY . /src
RUN python3 -m venv /opt/foundry \
 && /opt/foundry/bin/pip install --no-cache-dir "/src[video,inspect,eee]" \
 && rm -rf /src
ENV PATH=/opt/foundry/bin:$PATH HOME=/tmp
WORKDIR /work
ENTRYPOINT ["foundry"]
CMD ["--help"]
