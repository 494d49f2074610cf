package procgenclient

import (
	"crypto/tls"
	"crypto/x509"
	"net"
	"os"
	"strings"

	"google.golang.org/grpc/codes"
)

// Credentials is how a client knows its server, and what it shows to it. Certificates and keys are paths of PEM files.
type Credentials struct {
	// Certificates that vouch for the server. Given: TLS is spoken. Empty: plain text.
	CA string
	// The client's own, for servers that ask for one; with Key and CA.
	Certificate string
	// The key of Certificate.
	Key string
	// Bears out who calls, for servers with tokens. Without TLS it is sent to this machine only (loopback, unix sockets),
	// unless TokenInPlainText.
	Token            string
	TokenInPlainText bool
}

// CredentialsFromEnvironment is what PROCGEN_SERVER_CA, _CERTIFICATE, _KEY (paths) and _TOKEN (the token itself) say.
func CredentialsFromEnvironment() Credentials {
	return Credentials{
		CA:          os.Getenv("PROCGEN_SERVER_CA"),
		Certificate: os.Getenv("PROCGEN_SERVER_CERTIFICATE"),
		Key:         os.Getenv("PROCGEN_SERVER_KEY"),
		Token:       os.Getenv("PROCGEN_SERVER_TOKEN"),
	}
}

// What TLS is spoken with to address; nil: plain text.
func (c Credentials) tlsConfig(address string) (*tls.Config, error) {
	if (c.Certificate == "") != (c.Key == "") {
		return nil, invalid("a client's certificate or its key is given alone; give both or none")
	}
	if c.CA == "" {
		if c.Certificate != "" {
			return nil, invalid("a client's certificate is given without certificates that vouch for the server; give CA, " +
				"or set PROCGEN_SERVER_CA")
		}
		if c.Token != "" && !c.TokenInPlainText && !isThisMachine(address) {
			return nil, invalid("the token would go to %s in plain text; give certificates that vouch for the server (CA, or "+
				"PROCGEN_SERVER_CA), or say TokenInPlainText", address)
		}
		return nil, nil
	}
	pem, err := os.ReadFile(c.CA)
	if err != nil {
		return nil, newError(codes.NotFound, "CA: %v", err)
	}
	config := &tls.Config{RootCAs: x509.NewCertPool(), MinVersion: tls.VersionTLS12}
	if !config.RootCAs.AppendCertsFromPEM(pem) {
		return nil, invalid("CA is %s, in which there is no certificate", c.CA)
	}
	if c.Certificate != "" {
		own, err := tls.LoadX509KeyPair(c.Certificate, c.Key)
		if err != nil {
			return nil, invalid("Certificate is %s and Key %s: %v", c.Certificate, c.Key, err)
		}
		config.Certificates = []tls.Certificate{own}
	}
	return config, nil
}

// Whether nobody else can listen on the way to address.
func isThisMachine(address string) bool {
	if strings.HasPrefix(address, "unix:") {
		return true
	}
	host, _, err := net.SplitHostPort(strings.TrimPrefix(address, "dns:///"))
	if err != nil {
		return false
	}
	// By its exact form: "127.0.0.1.example.com" is a name.
	ip := net.ParseIP(host)
	return strings.EqualFold(host, "localhost") || ip != nil && ip.IsLoopback()
}
