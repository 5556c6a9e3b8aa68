# The workflow with all that it needs: docs/clusters.md, "Containers".
# Its base is named by a tag, not by a digest: a digest would keep out Debian's security updates, and is of one kind of
# processor. Packages of Python have hashes but for torch, for the reason in the Makefile.
FROM debian:bookworm-slim
RUN apt-get update \
    && apt-get install --yes --no-install-recommends python3-venv \
    && rm -rf /var/lib/apt/lists/*
COPY . /opt/source
RUN python3 -m venv /opt/ur5lib \
    && /opt/ur5lib/bin/pip install --no-cache-dir --require-hashes --no-deps \
        --requirement /opt/source/requirements.lock \
    && /opt/ur5lib/bin/pip install --no-cache-dir --no-build-isolation /opt/source \
    && rm -rf /opt/source
ENV PATH=/opt/ur5lib/bin:/usr/local/bin:/usr/bin:/bin
WORKDIR /lab
CMD ["snakemake"]
